// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/io/report_file.hpp"

namespace raybundle::apps {

/// `pictures` of report.json, small JPEGs in base64: of each camera its worst views and one view undistorted, of each
/// pair with the first camera one frame rectified, the last two with lines that have to run along what is straight.
/// Images that cannot be read (frames of videos, corners without images) give none.
ReportSection pictures_section(const CalibrationProblem& problem, const CalibrationResult& result, int threads);

}  // namespace raybundle::apps
