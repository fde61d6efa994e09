// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "raybundle/camera/camera.hpp"
#include "raybundle/device/image_view.hpp"
#include "raybundle/stereo/match.hpp"
#include "raybundle/stereo/match_options.hpp"

namespace raybundle {

struct DisparityView {
  ImageView<const float> disparity_px;  ///< 0 where there is no match
  ImageView<const float> sigma_px;      ///< standard deviation of a match that is right, 0 where there is none
  ImageView<const std::uint8_t> match;  ///< Match of each pixel
  int matched = 0;                      ///< pixels that are matched
};

/// Dense matching of rectified images. All memory is taken by the constructor; match() takes none, throws nothing, and
/// gives the same bits whatever the machine.
class Matcher {
 public:
  /// @throws Error(kBadInput) for options or a size that cannot be
  Matcher(ImageSize size, const MatchOptions& options);
  ~Matcher();
  Matcher(Matcher&&) noexcept;
  Matcher& operator=(Matcher&&) noexcept;

  /// @param left           rectified, of the size given at the start
  /// @param left_covered   width × height, 0 where the image has no source; nullptr: all of it has
  /// @return               valid until the next call
  DisparityView match(GreyView left, GreyView right, const std::uint8_t* left_covered = nullptr,
                      const std::uint8_t* right_covered = nullptr);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace raybundle
