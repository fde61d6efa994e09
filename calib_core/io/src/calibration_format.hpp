// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace raybundle {

inline constexpr const char* kCalibrationFormat = "raybundle calibration";
inline constexpr int kCalibrationVersion = 1;
inline constexpr double kSelfTestTolerance_px = 1e-6;  ///< arithmetic differs between machines by less

}  // namespace raybundle
