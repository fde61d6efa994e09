// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl/filesystem.h>

#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "bindings.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/report_file.hpp"

namespace raybundle::python {
namespace {

namespace py = pybind11;

/// A result with the problem that it answers, and how.
struct Solved {
  CalibrationProblem problem;
  CalibrateOptions options;
  CalibrationResult result;
};

CalibrateOptions options_from(const py::kwargs& words) {
  CalibrateOptions options;
  std::string known;
  std::size_t used = 0;
  CalibrateOptions::for_each_option(options, [&](const char* name, const char*, const char*, auto& value) {
    known += (known.empty() ? "" : ", ") + std::string(name);
    if (!words.contains(name)) return;
    try {
      value = words[name].template cast<std::decay_t<decltype(value)>>();
    } catch (const py::cast_error&) {
      throw py::type_error(std::string(name) + " has to be like " + std::string(py::str(py::cast(value))));
    }
    ++used;
  });
  if (used != words.size()) throw py::type_error("calibrate() knows these options: " + known);
  return options;
}

Solved solve(const CalibrationProblem& problem, const py::kwargs& words) {
  Solved solved{problem, options_from(words), {}};
  const py::gil_scoped_release others_may_run;  // who may change the problem, but not the copy
  solved.result = calibrate(solved.problem, solved.options);
  return solved;
}

Provenance provenance_of(const CalibrateOptions& options) {
  Provenance provenance{"raybundle.calibrate() of the Python module", {}, {}, {{"raybundle", RAYBUNDLE_VERSION}}};
  CalibrateOptions::for_each_option(options, [&](std::string_view name, const char*, const char*, const auto& value) {
    if (name == "threads") return;  // the result does not depend on them
    provenance.options.emplace_back(name, fmt::format("{}", value));
  });
  return provenance;
}

CalibrationFile file_of(const Solved& solved) {
  return calibration_file(solved.problem, solved.result, provenance_of(solved.options));
}

// Residuals of a view, one row for each of its observations; NaN for those that were left out.
Rows<2> residuals_of(const Solved& solved, std::size_t view) {
  if (view >= solved.result.views.size()) throw py::index_error("there is no such view");
  const auto& residuals = solved.result.views[view].residuals_px;
  Rows<2> rows(static_cast<Eigen::Index>(residuals.size()), 2);
  for (std::size_t i = 0; i < residuals.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = residuals[i].transpose();
  return rows;
}

}  // namespace

void bind_calibrate(py::module_& module) {
  py::class_<Solved>(module, "Result", "Everything a solve can be audited by.")
      .def_property_readonly("calibration", &file_of)
      .def_property_readonly("rms_px", [](const Solved& solved) { return solved.result.rms_px; })
      .def_property_readonly("warnings", [](const Solved& solved) { return solved.result.warnings; })
      .def_property_readonly(
          "set_aside",
          [](const Solved& solved) {
            std::vector<std::pair<std::string, std::string>> views;
            for (const SetAside& aside : solved.result.set_aside) {
              views.emplace_back(view_name(solved.problem, solved.problem.views[aside.view]), aside.reason);
            }
            return views;
          },
          "Views, or their ties, that were not used, and why.")
      .def_property_readonly(
          "rig_from_target",
          [](const Solved& solved) {
            std::vector<std::tuple<std::string, std::string, Eigen::Matrix4d>> poses;
            for (const BoardPose& pose : solved.result.poses) {
              poses.emplace_back(solved.problem.frames[pose.frame], solved.problem.targets[pose.target].name,
                                 matrix_from_rigid3(pose.rig_from_target));
            }
            return poses;
          },
          "Frame, board and pose (4, 4) of each board in each frame.")
      .def("residuals", &residuals_of, py::arg("view"),
           "Measured minus projected (N, 2) [px] of a view's observations; NaN for those that were left out.")
      .def(
          "write_calibration",
          [](const Solved& solved, const std::filesystem::path& path) { write_calibration(path, file_of(solved)); },
          py::arg("path"), "Writes calibration.json, whole or not at all.")
      .def(
          "write_report",
          [](const Solved& solved, const std::filesystem::path& path) {
            write_report(path, solved.problem, solved.result, {{}, provenance_of(solved.options)});
          },
          py::arg("path"), "Writes report.json, of which `raybundle report` makes a page.");

  std::string doc = "Intrinsics, extrinsics, board poses and shapes in one bundle adjustment. Options:\n";
  CalibrateOptions defaults;
  CalibrateOptions::for_each_option(defaults,
                                    [&](const char* name, const char* unit, const char* help, const auto& value) {
                                      doc += "\n  " + std::string(name) + " = " + std::string(py::str(py::cast(value)));
                                      doc += (*unit ? " [" + std::string(unit) + "]" : "") + ": " + help;
                                    });
  module.def("calibrate", &solve, py::arg("problem"), doc.c_str());
}

}  // namespace raybundle::python
