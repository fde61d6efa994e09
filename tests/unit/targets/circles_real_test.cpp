// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/targets/detect.hpp"
#include "real_images.hpp"

namespace raybundle {
namespace {

struct CircleSet {
  const char* folder;
  const char* prefix;
  std::size_t images;
  Board board;
};

void PrintTo(const CircleSet& set, std::ostream* out) { *out << set.folder; }

class RealCircles : public ::testing::TestWithParam<CircleSet> {};

TEST_P(RealCircles, AreFoundInEveryImage) {
  const CircleSet& set = GetParam();
  const auto files = testing::real_images(set.folder, set.prefix);
  RAYBUNDLE_NEEDS_IMAGES(files, set.folder);
  EXPECT_EQ(files.size(), set.images);
  const auto points = static_cast<double>(target_of(set.board).points.size());
  for (const auto& file : files) {
    const Detection detection = detect(set.board, testing::grey_image(file));
    EXPECT_GE(static_cast<double>(detection.observations.size()), 0.9 * points) << file << " " << detection.hint;
    EXPECT_TRUE(detection.hint.empty()) << detection.hint;
  }
}

// What lies beside the board comes first in the image then, or last.
TEST_P(RealCircles, AreFoundHoweverTheImageLies) {
  const CircleSet& set = GetParam();
  const auto files = testing::real_images(set.folder, set.prefix);
  RAYBUNDLE_NEEDS_IMAGES(files, set.folder);
  const auto points = static_cast<double>(target_of(set.board).points.size());
  for (const auto& file : files) {
    cv::Mat turned;
    cv::rotate(testing::grey_image(file), turned, cv::ROTATE_180);
    const Detection detection = detect(set.board, turned);
    EXPECT_GE(static_cast<double>(detection.observations.size()), 0.9 * points) << file << " " << detection.hint;
  }
}

// BoofCV counts rows and columns of its hexagonal grid by half steps, with y up: the mirror image of ours.
INSTANTIATE_TEST_SUITE_P(
    Sets, RealCircles,
    ::testing::Values(CircleSet{"boofcv_mono/Sony_DSC-HX5V_CircleRegular", "image", 6, Circles{10, 8, 0.025}},
                      CircleSet{"boofcv_mono/Sony_DSC-HX5V_CircleHexagonal", "image", 7,
                                AsymmetricCircles{14, 24, 0.006, 0.006 * std::sqrt(3.0), true}},
                      CircleSet{"visp_circlegrid", "grid36", 4, Circles{6, 6, 0.03}},
                      CircleSet{"linelight_zhao/calib_picture", "calib", 12, Circles{7, 7, 0.02}}));

TEST(RealCirclesHint, OfAnotherSizeOrTheMirrorImageNameTheSetting) {
  const char* folder = "boofcv_mono/Sony_DSC-HX5V_CircleHexagonal";
  const auto files = testing::real_images(folder);
  RAYBUNDLE_NEEDS_IMAGES(files, folder);
  const cv::Mat image = testing::grey_image(files.front());
  const Detection mirrored = detect(AsymmetricCircles{14, 24, 0.006, 0.006 * std::sqrt(3.0)}, image);
  EXPECT_TRUE(mirrored.observations.empty());
  EXPECT_NE(mirrored.hint.find("first_row_shifted = true"), std::string::npos) << mirrored.hint;
  const Detection smaller = detect(AsymmetricCircles{12, 24, 0.006, 0.006 * std::sqrt(3.0), true}, image);
  EXPECT_TRUE(smaller.observations.empty());
  EXPECT_NE(smaller.hint.find("336 circles"), std::string::npos) << smaller.hint;
}

}  // namespace
}  // namespace raybundle
