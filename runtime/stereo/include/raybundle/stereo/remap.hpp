// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/stereo/extent.hpp"
#include "raybundle/stereo/rectified_camera.hpp"
#include "raybundle/stereo/simd.hpp"

namespace raybundle {

/// Where each pixel of a rectified image comes from in the camera's image: distortion and rectification in one step.
/// Positions are held to 1/256 px, so a table is within 1/512 px of the exact model along each axis.
struct RemapTable {
  ImageSize source;
  ImageSize size;
  std::vector<std::int32_t> x_256;    ///< [1/256 px], size.width × size.height; 0 where there is no source
  std::vector<std::int32_t> y_256;    ///< [1/256 px]
  std::vector<std::uint8_t> covered;  ///< 1 where the camera's image shows the ray, else 0

  Extent extent(int row) const {
    return Extent::of(covered.data() + static_cast<std::ptrdiff_t>(row) * size.width, size.width);
  }
};

/// @param rectified_from_camera  rotation
RemapTable remap_table(const Camera& camera, const RectifiedCamera& rectified,
                       const Eigen::Quaterniond& rectified_from_camera);

/// Bilinear interpolation with whole numbers: all paths give the same bits. Pixels that are not covered become 0.
///
/// @param image  of table.source size
/// @param out    of table.size
void remap(const RemapTable& table, GreyView image, ImageView<std::uint8_t> out, Simd simd = best_simd());

}  // namespace raybundle
