// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "raybundle/io/provenance.hpp"
#include "raybundle/scene/problem.hpp"
#include "raybundle/scene/result.hpp"

namespace raybundle {

/// An image that gave no view.
struct UnusedImage {
  std::string camera;
  std::string frame;
  std::string image;   ///< path
  std::string reason;  ///< one clause: no board found, cannot be decoded, ...
};

/// A key of report.json that other parts of the program fill: a verdict, a comparison, pictures.
struct ReportSection {
  std::string name;
  std::string json;  ///< its value
};

/// What a report holds beside problem and result.
struct ReportExtra {
  std::vector<UnusedImage> unused_images;
  Provenance provenance;
  std::vector<ReportSection> sections = {};  ///< in the order in which they are written
};

/// The text of report.json: everything that a report needs. Format: docs/formats/report.md,
/// docs/schemas/report.schema.json. Numbers that do not exist (the residual of a point that does not project) are null.
/// It has no "<", so that it may stand in a page as it is.
std::string text_from_report(const CalibrationProblem& problem, const CalibrationResult& result,
                             const ReportExtra& extra = {});

/// Writes report.json, whole or not at all.
void write_report(const std::filesystem::path& path, const CalibrationProblem& problem, const CalibrationResult& result,
                  const ReportExtra& extra = {});

}  // namespace raybundle
