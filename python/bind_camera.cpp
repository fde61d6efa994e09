// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <string>

#include "bindings.hpp"
#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::python {
namespace {

namespace py = pybind11;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Camera make_camera(const std::string& model, int width, int height, const Eigen::VectorXd& parameters) {
  Camera camera{model_of(model), {width, height}, parameters};
  const auto names = parameter_names(camera.model);
  if (parameters.size() != static_cast<Eigen::Index>(names.size())) {
    std::string text;
    for (const std::string_view name : names) text += " " + std::string(name);
    throw Error(ErrorKind::kBadInput, model + " has " + std::to_string(names.size()) + " parameters:" + text);
  }
  if (!parameters.allFinite() || !(camera.fx() > 0 && camera.fy() > 0) || width < 1 || height < 1) {
    throw Error(ErrorKind::kBadInput, "a camera needs an image, finite parameters and positive focal lengths");
  }
  return camera;
}

Rows<2> project(const Camera& camera, const Eigen::Ref<const Rows<3>>& rays) {
  Rows<2> pixels = Rows<2>::Constant(rays.rows(), 2, kNone);
  for (Eigen::Index i = 0; i < rays.rows(); ++i) {
    if (!(rays.row(i).squaredNorm() > 0)) continue;
    if (const auto pixel = pixel_from_ray(camera, rays.row(i).transpose())) pixels.row(i) = pixel->transpose();
  }
  return pixels;
}

Rows<3> unproject(const Camera& camera, const Eigen::Ref<const Rows<2>>& pixels) {
  Rows<3> rays = Rows<3>::Constant(pixels.rows(), 3, kNone);
  for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
    if (const auto ray = ray_from_pixel(camera, pixels.row(i).transpose())) rays.row(i) = ray->transpose();
  }
  return rays;
}

py::dict parameters_by_name(const Camera& camera) {
  py::dict parameters;
  const auto names = parameter_names(camera.model);
  for (std::size_t i = 0; i < names.size(); ++i) {
    parameters[py::str(std::string(names[i]))] = camera.parameters[static_cast<Eigen::Index>(i)];
  }
  return parameters;
}

}  // namespace

ModelId model_of(const std::string& name) {
  if (const auto model = model_named(name)) return *model;
  std::string known;
  for (const std::string_view each : model_names()) known += (known.empty() ? "" : ", ") + std::string(each);
  throw Error(ErrorKind::kBadInput, "'" + name + "' is no camera model; known: " + known);
}

void bind_camera(py::module_& module) {
  module.def(
      "camera_models",
      [] {
        std::vector<std::string> names;
        for (const std::string_view name : model_names()) names.emplace_back(name);
        return names;
      },
      "Names of all camera models.");
  module.def(
      "parameter_names",
      [](const std::string& model) {
        std::vector<std::string> names;
        for (const std::string_view name : parameter_names(model_of(model))) names.emplace_back(name);
        return names;
      },
      py::arg("model"), "Parameters of a model in their order: fx, fy, cx, cy, then its shape.");

  py::class_<Camera>(module, "Camera", "A calibrated camera: a model, its parameters and the size of its image.")
      .def(py::init(&make_camera), py::arg("model"), py::arg("width"), py::arg("height"), py::arg("parameters"))
      .def_property_readonly("model", [](const Camera& camera) { return std::string(model_name(camera.model)); })
      .def_property_readonly("width", [](const Camera& camera) { return camera.size.width; })
      .def_property_readonly("height", [](const Camera& camera) { return camera.size.height; })
      .def_readonly("parameters", &Camera::parameters, "fx fy cx cy [px], then the model's shape")
      .def("named_parameters", &parameters_by_name, "The parameters by their names.")
      .def("project", &project, py::arg("rays"),
           "Pixels (N, 2) of rays or points (N, 3) in the camera's frame; NaN where the camera does not see one.")
      .def("unproject", &unproject, py::arg("pixels"),
           "Unit rays (N, 3) in the camera's frame of pixels (N, 2); NaN where there is none.")
      .def_property_readonly(
          "max_angle", [](const Camera& camera) { return max_angle_rad(camera); },
          "Half-angle [rad] up to which the radial profile is increasing.")
      .def("__repr__", [](const Camera& camera) {
        return "<raybundle.Camera " + std::string(model_name(camera.model)) + " " + std::to_string(camera.size.width) +
               "x" + std::to_string(camera.size.height) + ">";
      });
}

}  // namespace raybundle::python
