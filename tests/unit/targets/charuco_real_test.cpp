// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "raybundle/targets/detect.hpp"
#include "real_images.hpp"

namespace raybundle {
namespace {

constexpr const char* kNew = "photonvision_charuco_small/lifecam_480";
constexpr const char* kLegacy = "photonvision_charuco_small/lifecam_1280_old_pattern";

Charuco lifecam_board() { return {8, 8, 0.0254, 0.01905, "DICT_4X4_1000", false, false}; }

TEST(RealCharuco, IsFoundInEveryImageOfTheNewLayout) {
  const auto files = testing::real_images(kNew);
  RAYBUNDLE_NEEDS_IMAGES(files, kNew);
  EXPECT_EQ(files.size(), 17u);
  for (const auto& file : files) {
    const Detection detection = detect(lifecam_board(), testing::grey_image(file));
    EXPECT_GE(detection.observations.size(), 30u) << file;  // two boards are cut by the image's edge
    for (const Observation& corner : detection.observations) {
      EXPECT_GT(corner.sigma_px, 0.0);
      EXPECT_LT(corner.sigma_px, 0.5);
    }
  }
}

TEST(RealCharuco, IsFoundInEveryImageOfTheLegacyLayout) {
  const auto files = testing::real_images(kLegacy);
  RAYBUNDLE_NEEDS_IMAGES(files, kLegacy);
  EXPECT_EQ(files.size(), 13u);
  Charuco board = lifecam_board();
  board.legacy = true;
  for (const auto& file : files) {
    EXPECT_GE(detect(board, testing::grey_image(file)).observations.size(), 40u) << file;
  }
}

TEST(RealCharuco, OfTheOtherLayoutGivesNothingButTheSettingToChange) {
  for (const bool legacy : {false, true}) {
    const auto files = testing::real_images(legacy ? kLegacy : kNew);
    RAYBUNDLE_NEEDS_IMAGES(files, legacy ? kLegacy : kNew);
    Charuco board = lifecam_board();
    board.legacy = !legacy;
    for (const auto& file : files) {
      const Detection detection = detect(board, testing::grey_image(file));
      EXPECT_TRUE(detection.observations.empty()) << file;
      EXPECT_NE(detection.hint.find(legacy ? "try :legacy (in TOML legacy = true)"
                                           : "try without :legacy (in TOML legacy = false)"),
                std::string::npos)
          << file << ": " << detection.hint;
    }
  }
}

// Some mirrored codes are others of so large a dictionary: they are not taken for a board of another size.
TEST(RealCharuco, OfAMirroredImageNamesTheMirror) {
  const auto files = testing::real_images(kNew);
  RAYBUNDLE_NEEDS_IMAGES(files, kNew);
  for (const auto& file : files) {
    cv::Mat mirrored;
    cv::flip(testing::grey_image(file), mirrored, 1);
    const Detection detection = detect(lifecam_board(), mirrored);
    EXPECT_TRUE(detection.observations.empty()) << file;
    EXPECT_NE(detection.hint.find("the images are mirrored"), std::string::npos) << file << ": " << detection.hint;
  }
}

TEST(RealCharuco, OfTheOtherPolarityDictionaryOrSizeNamesIt) {
  const auto files = testing::real_images(kNew);
  RAYBUNDLE_NEEDS_IMAGES(files, kNew);
  const cv::Mat image = testing::grey_image(files.front());
  cv::Mat inverse;
  cv::bitwise_not(image, inverse);
  EXPECT_NE(detect(lifecam_board(), inverse).hint.find("try :inverted (in TOML inverted = true)"), std::string::npos);
  Charuco board = lifecam_board();
  board.inverted = true;
  EXPECT_NE(detect(board, image).hint.find("try without :inverted (in TOML inverted = false)"), std::string::npos);
  EXPECT_EQ(detect(board, inverse).observations.size(), detect(lifecam_board(), image).observations.size());

  board = lifecam_board();
  board.dictionary = "DICT_5X5_1000";
  const Detection other = detect(board, image);
  EXPECT_TRUE(other.observations.empty());
  EXPECT_NE(other.hint.find("DICT_4X4_1000"), std::string::npos) << other.hint;

  board = lifecam_board();
  board.marker_m = 0.6 * board.square_m;  // where 0.75 are right
  const Detection small = detect(board, testing::grey_image(files.back()));
  EXPECT_TRUE(small.observations.empty());
  EXPECT_NE(small.hint.find("not 15.2 mm: measure both"), std::string::npos) << small.hint;

  board = lifecam_board();
  board.columns = 7;
  const Detection narrow = detect(board, image);
  EXPECT_TRUE(narrow.observations.empty());
  EXPECT_NE(narrow.hint.find("columns and rows"), std::string::npos) << narrow.hint;
}

}  // namespace
}  // namespace raybundle
