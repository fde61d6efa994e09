// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace raybundle::testing {

/// Baseline [squares] of OpenCV's own joint solution of its stereo pairs: findChessboardCorners, cornerSubPix,
/// calibrateCamera of each camera, then stereoCalibrate of everything with those intrinsics as the guess.
double opencv_baseline_in_squares(const std::filesystem::path& folder);

}  // namespace raybundle::testing
