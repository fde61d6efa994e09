// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fresh_folder.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "real_data.hpp"
#include "text_file.hpp"

/// The program as a person runs it: its command line in, exit code, streams and files out.
namespace raybundle::testing {

/// What one run of the program left behind.
struct ProgramRun {
  int exit_code = -1;
  std::string out, err;
};

/// The cache of the tests of one build: images are looked at once. A rebuilt program starts anew.
std::filesystem::path cache_of_this_build();

/// Runs `raybundle <arguments>` with `input` on stdin. Unless said its cache is one that only this build of the program
/// has used, so that a test never sees what another version found.
ProgramRun raybundle_program(const std::vector<std::string>& arguments, const std::string& input = "",
                             const std::filesystem::path& cache = cache_of_this_build());

nlohmann::json json_of(const std::filesystem::path& file);

/// The entry of a report's or calibration's cameras[].
const nlohmann::json& camera_in(const nlohmann::json& document, const std::string& name);

/// camera_from_rig of a camera of calibration.json.
Rigid3 camera_from_rig(const nlohmann::json& calibration, const std::string& name);

/// Distance [m] between two cameras of calibration.json.
double baseline_m(const nlohmann::json& calibration, const std::string& a, const std::string& b);

/// Corners of every view of an observations.json or report.json by camera and frame.
std::map<std::string, std::map<std::string, int>> corners_by_frame(const nlohmann::json& document);

/// Number of views of a camera with at least so many corners.
int views_with(const nlohmann::json& document, const std::string& camera, int corners);

/// calibration.json without provenance: what must not depend on threads or time.
std::string without_provenance(const std::filesystem::path& calibration);

/// Calibrates with `arguments` into folder/out, expects success, and returns report.json.
nlohmann::json calibrate(const std::filesystem::path& folder, std::vector<std::string> arguments);

/// Detects with `arguments` into folder/observations.json, expects success, and returns it.
nlohmann::json detect(const std::filesystem::path& folder, std::vector<std::string> arguments);

}  // namespace raybundle::testing

/// Skips a test, saying so, when a folder of the real data is not there.
#define RAYBUNDLE_NEEDS_DATA(folder)                                                    \
  if (!std::filesystem::is_directory(raybundle::testing::real_data(folder))) {          \
    GTEST_SKIP() << "there is no " << raybundle::testing::real_data(folder)             \
                 << ": set RAYBUNDLE_DATA to the folder of real data to run this test"; \
  }
