// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace raybundle::testing {

/// Corners that Kalibr's tools detected, as lines `camera,frame,point_id,u,v`. A folder holds one file for each image
/// of ts,tag_rows,tag_cols,tag_size,tag_spacing,kp_x,kp_y,p_x,p_y,p_z,tag_id,corner_idx.
std::string csv_of_kalibr_corners(const std::filesystem::path& folder, const std::string& camera);

}  // namespace raybundle::testing
