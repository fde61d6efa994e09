// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <string>

#include "bindings.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/observations_file.hpp"

namespace raybundle::python {
namespace {

namespace py = pybind11;

// Index of what has that name in a list of named things.
template <typename List, typename Projection>
int index_named(const List& list, const std::string& name, const char* what, Projection projection) {
  const auto found = std::ranges::find(list, name, projection);
  if (found != list.end()) return static_cast<int>(found - list.begin());
  throw Error(ErrorKind::kBadInput, std::string("there is no ") + what + " '" + name + "'; add it first");
}

void add_camera(CalibrationProblem& problem, const std::string& name, const std::string& model, int width, int height) {
  problem.cameras.push_back({name, model_of(model), {width, height}, std::nullopt, std::nullopt});
}

void add_target(CalibrationProblem& problem, const std::string& name, const Eigen::Ref<const Rows<3>>& points) {
  Target target{name, {}, {}};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    target.points.push_back({static_cast<int>(i), points.row(i).transpose()});
  }
  problem.targets.push_back(target);
}

// Without a name it is the board that there is, if there is one only.
int target_of_view(const CalibrationProblem& problem, const std::string& name) {
  if (!name.empty()) return index_named(problem.targets, name, "target", &Target::name);
  if (problem.targets.size() == 1) return 0;
  if (problem.targets.empty()) throw Error(ErrorKind::kBadInput, "there is no target; add one before its views");
  throw Error(ErrorKind::kBadInput, "there are " + std::to_string(problem.targets.size()) +
                                        " targets; say which one the view shows, as target='" +
                                        problem.targets.back().name + "'");
}

void add_view(CalibrationProblem& problem, const std::string& camera, const std::string& frame,
              const std::vector<int>& ids, const Eigen::Ref<const Rows<2>>& pixels, double sigma_px,
              const std::string& target) {
  if (static_cast<Eigen::Index>(ids.size()) != pixels.rows()) {
    throw Error(ErrorKind::kBadInput, "a view needs as many ids as pixels");
  }
  TargetView view;
  view.camera = index_named(problem.cameras, camera, "camera", &ProblemCamera::name);
  view.target = target_of_view(problem, target);
  const auto known = std::ranges::find(problem.frames, frame);
  view.frame = static_cast<int>(known - problem.frames.begin());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    view.observations.push_back({pixels.row(static_cast<Eigen::Index>(i)).transpose(), sigma_px, ids[i]});
  }
  if (known == problem.frames.end()) problem.frames.push_back(frame);
  problem.views.push_back(view);
}

void add_rule(CalibrationProblem& problem, const std::string& pattern, ParameterRule::Kind kind,
              std::optional<double> value, double sigma) {
  problem.rules.push_back({pattern, kind, value, sigma});
}

}  // namespace

void bind_problem(py::module_& module) {
  py::class_<CalibrationProblem>(module, "Problem", "Views of boards by cameras, in frames (moments in time).")
      .def(py::init<>())
      .def("add_camera", &add_camera, py::arg("name"), py::arg("model"), py::arg("width"), py::arg("height"),
           "The first camera defines the rig. No focal length is asked for.")
      .def("add_target", &add_target, py::arg("name"), py::arg("points"),
           "A board with points (N, 3) [m] in its own frame; a point's id is its row.")
      .def("add_view", &add_view, py::arg("camera"), py::arg("frame"), py::arg("ids"), py::arg("pixels"),
           py::arg("sigma_px") = 1.0, py::arg("target") = "",
           "What a camera saw of a board in a frame: pixels (N, 2) of the points with these ids. `target` names the "
           "board where there are several.")
      .def(
          "fix",
          [](CalibrationProblem& problem, const std::string& pattern, double value) {
            add_rule(problem, pattern, ParameterRule::Kind::kFixed, value, 0.0);
          },
          py::arg("pattern"), py::arg("value"), "Holds parameters, as *.k3 at 0.")
      .def(
          "prior",
          [](CalibrationProblem& problem, const std::string& pattern, double value, double sigma) {
            add_rule(problem, pattern, ParameterRule::Kind::kPrior, value, sigma);
          },
          py::arg("pattern"), py::arg("value"), py::arg("sigma"), "What is known of parameters beforehand.")
      .def_property_readonly("cameras",
                             [](const CalibrationProblem& problem) {
                               std::vector<std::string> names;
                               for (const ProblemCamera& camera : problem.cameras) names.push_back(camera.name);
                               return names;
                             })
      .def_readonly("frames", &CalibrationProblem::frames)
      .def(
          "__len__", [](const CalibrationProblem& problem) { return problem.views.size(); }, "Number of views.");

  module.def(
      "read_observations",
      [](const std::filesystem::path& path, const std::string& model) {
        ObservationsFile file = read_observations(path);
        for (std::size_t i = 0; i < file.models.size(); ++i) {
          if (!model.empty()) {
            file.problem.cameras[i].model = model_of(model);
          } else if (!file.models[i]) {
            throw Error(
                ErrorKind::kBadInput,
                "names no model for camera " + file.problem.cameras[i].name + "; give one, as model='kannala_brandt'",
                path.string());
          }
        }
        return file.problem;
      },
      py::arg("path"), py::arg("model") = "", "Reads observations.json; `model` is for all cameras.");
}

}  // namespace raybundle::python
