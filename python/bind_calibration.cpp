// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "bindings.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/uncertainty/projection_uncertainty.hpp"

namespace raybundle::python {
namespace {

namespace py = pybind11;

// By the noise of the corners, by how the frames scatter, or, for each pixel, by whichever is larger.
Eigen::VectorXd projection_sigma(const CalibrationFile& file, const std::string& camera,
                                 const Eigen::Ref<const Rows<2>>& pixels, double range_m, const std::string& by) {
  const Calibration& calibration = file.calibration;
  if (by != "larger" && by != "corners" && by != "frames")
    throw py::value_error("by is 'larger', 'corners' or 'frames'");
  if (!(range_m > 0.0)) throw py::value_error("range_m has to be above 0; math.inf is for points that are far away");
  if (by == "frames" && !calibration.covariance_by_frame) {
    throw Error(ErrorKind::kNotEnoughData, "fewer than ten frames do not tell how they scatter; ask by='corners'");
  }
  std::vector<ProjectionUncertainty> asked;
  const RigCamera& rig_camera = camera_named(calibration, camera);
  if (by != "frames") asked.push_back(projection_uncertainty(rig_camera, calibration.covariance));
  if (by != "corners" && calibration.covariance_by_frame) {
    asked.push_back(projection_uncertainty(rig_camera, *calibration.covariance_by_frame));
  }
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(pixels.rows(), std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index i = 0; i < pixels.rows(); ++i) {
    for (const ProjectionUncertainty& uncertainty : asked) {
      const auto covariance = projection_covariance(uncertainty, pixels.row(i).transpose(), range_m);
      if (covariance) sigmas[i] = std::fmax(sigmas[i], largest_sigma(*covariance));
    }
  }
  return sigmas;
}

CalibrationFile without_sigmas(std::vector<RigCamera> cameras) {
  // With evidence, but without the covariance that belongs to it, they would seem to be perfectly known.
  for (RigCamera& camera : cameras) camera.evidence.reset();
  CalibrationFile file;
  file.calibration.cameras = std::move(cameras);
  file.provenance.command = "raybundle.Calibration() of the Python module";
  file.provenance.versions = {{"raybundle", RAYBUNDLE_VERSION}};
  return file;
}

// What was held has no sigma, and what is misspelt has none either: neither is perfectly known.
void require_names(const Covariance& covariance, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::find(covariance.names, name) != covariance.names.end()) continue;
    throw Error(ErrorKind::kBadInput, "'" + name +
                                          "' is not among the names of this covariance: it was not estimated." +
                                          did_you_mean(name, covariance.names));
  }
}

void bind_parts(py::module_& module) {
  py::class_<RigCamera>(module, "RigCamera", "A camera in its place on the rig.")
      .def(py::init([](const std::string& name, const Camera& camera, const Eigen::Matrix4d& camera_from_rig) {
             return RigCamera{name, camera, rigid3_of(camera_from_rig)};
           }),
           py::arg("name"), py::arg("camera"),
           py::arg("camera_from_rig") = Eigen::Matrix4d(Eigen::Matrix4d::Identity()))
      .def_readonly("name", &RigCamera::name)
      .def_readonly("camera", &RigCamera::camera)
      .def_property_readonly("camera_from_rig",
                             [](const RigCamera& camera) { return matrix_from_rigid3(camera.camera_from_rig); });

  py::class_<Covariance>(module, "Covariance", "Joint covariance of named parameters, as left.fx.")
      .def_readonly("names", &Covariance::names)
      .def_readonly("matrix", &Covariance::matrix)
      .def(
          "sigma",
          [](const Covariance& covariance, const std::string& name) {
            require_names(covariance, {name});
            return covariance.sigma(name);
          },
          py::arg("name"), "Standard deviation of one of the names.")
      .def(
          "block",
          [](const Covariance& covariance, const std::vector<std::string>& names) {
            require_names(covariance, names);
            return covariance.block(names);
          },
          py::arg("names"), "The part of the matrix for some of the names.");

  py::class_<LaserBeam>(module, "LaserBeam", "One beam of a dot projector: a line in the rig's frame.")
      .def_readonly("row", &LaserBeam::row)
      .def_readonly("column", &LaserBeam::column)
      .def_property_readonly(
          "point", [](const LaserBeam& beam) { return beam.line.point; }, "on the line [m]")
      .def_property_readonly(
          "direction", [](const LaserBeam& beam) { return beam.line.direction; }, "unit vector")
      .def_readonly("covariance", &LaserBeam::covariance, "of two offsets [m] and two slopes [rad] across the line");
}

}  // namespace

void bind_calibration(py::module_& module) {
  bind_parts(module);
  py::class_<CalibrationFile>(module, "Calibration",
                              "What is saved: cameras, extrinsics, beams, and how well they are known.")
      .def(py::init(&without_sigmas), py::arg("cameras"), "Cameras without sigmas, as from another program.")
      .def_property_readonly(
          "cameras",
          [](const CalibrationFile& file) -> const std::vector<RigCamera>& { return file.calibration.cameras; })
      .def(
          "__getitem__",
          [](const CalibrationFile& file, const std::string& name) -> const RigCamera& {
            return camera_named(file.calibration, name);
          },
          py::arg("name"), py::return_value_policy::reference_internal)
      .def_property_readonly(
          "covariance", [](const CalibrationFile& file) -> const Covariance& { return file.calibration.covariance; },
          "for errors that are independent from corner to corner")
      .def_property_readonly(
          "covariance_by_frame",
          [](const CalibrationFile& file) -> const std::optional<Covariance>& {
            return file.calibration.covariance_by_frame;
          },
          "from how the frames disagree; None for fewer than ten frames")
      .def_property_readonly("beams",
                             [](const CalibrationFile& file) {
                               const auto& laser = file.calibration.laser;
                               return laser ? laser->beams : std::vector<LaserBeam>{};
                             })
      .def(
          "projection_sigma", &projection_sigma, py::arg("camera"), py::arg("pixels"),
          py::arg("range_m") = kInfinitelyFar, py::arg("by") = "larger",
          "Standard deviations (N) [px] of where a camera sees points that it now sees at pixels (N, 2), at a range: by "
          "the noise of the corners, by how the frames scatter, or the larger of both. NaN where there is no ray.")
      .def("__len__", [](const CalibrationFile& file) { return file.calibration.cameras.size(); })
      .def("__contains__",
           [](const CalibrationFile& file, const std::string& name) {
             const std::vector<RigCamera>& cameras = file.calibration.cameras;
             return std::ranges::find(cameras, name, &RigCamera::name) != cameras.end();
           })
      .def(
          "__iter__",
          [](const CalibrationFile& file) {
            return py::make_iterator(file.calibration.cameras.begin(), file.calibration.cameras.end());
          },
          py::keep_alive<0, 1>());

  module.def("read_calibration", &read_calibration, py::arg("path"),
             "Reads calibration.json and replays its self-test.");
  module.def(
      "write_calibration",
      [](const CalibrationFile& file, const std::filesystem::path& path) { write_calibration(path, file); },
      py::arg("calibration"), py::arg("path"),
      "Writes calibration.json, whole or not at all; of one that was read, with all that its file said.");
}

}  // namespace raybundle::python
