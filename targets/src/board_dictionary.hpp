// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/aruco/dictionary.hpp>
#include <string>
#include <vector>

namespace raybundle {

/// Names of OpenCV's predefined ArUco dictionaries, DICT_4X4_50 and so on.
std::vector<std::string> dictionary_names();

/// Names of what an AprilGrid can carry: the AprilTag families 36h11, 25h9, 16h5, and the dictionaries.
std::vector<std::string> tag_family_names();

/// Bit patterns of a dictionary. Throws Error(kBadInput) with a suggestion when there is none of that name.
cv::Ptr<cv::aruco::Dictionary> dictionary_named(const std::string& name);

/// Bit patterns of one of those. Throws Error(kBadInput) with a suggestion when there is none of that name.
cv::Ptr<cv::aruco::Dictionary> tag_family_named(const std::string& family);

}  // namespace raybundle
