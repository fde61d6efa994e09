// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "../../../targets/src/chessboard.hpp"
#include "real_data.hpp"

namespace raybundle {
namespace {

/// A set of real images and how many of them must give how many corners. It does not check where the corners are: that
/// is left to the calibrations of the same sets.
struct RealSet {
  const char* folder;
  const char* prefix;
  int columns, rows;
  int images;       ///< in the folder
  int most_missed;  ///< images without a board that are tolerated
  int corners;      ///< that an image must give to count
};

void PrintTo(const RealSet& set, std::ostream* out) {
  *out << set.folder << "/" << set.prefix << " as " << set.columns << "x" << set.rows;
}

class ChessboardReal : public ::testing::TestWithParam<RealSet> {};

TEST_P(ChessboardReal, BoardsAreFound) {
  const RealSet& set = GetParam();
  const std::filesystem::path folder = testing::real_data(set.folder);
  if (!std::filesystem::is_directory(folder)) {
    GTEST_SKIP() << "there is no " << folder << "; set RAYBUNDLE_DATA to the folder of real data";
  }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string extension = entry.path().extension();
    const bool image = extension == ".jpg" || extension == ".png";
    if (image && entry.path().filename().string().starts_with(set.prefix)) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  ASSERT_EQ(static_cast<int>(files.size()), set.images);
  std::string missed;
  int misses = 0;
  for (const auto& file : files) {
    const auto found =
        detect_chessboard(cv::imread(file.string(), cv::IMREAD_GRAYSCALE), {set.columns, set.rows, 0.03});
    if (static_cast<int>(found.observations.size()) >= set.corners) continue;
    ++misses;
    missed.append(" ")
        .append(file.filename().string())
        .append(" with ")
        .append(std::to_string(found.observations.size()));
  }
  EXPECT_LE(misses, set.most_missed) << missed;
}

INSTANTIATE_TEST_SUITE_P(Sets, ChessboardReal,
                         ::testing::Values(RealSet{"sourishg_fisheye_stereo/imgs", "left", 9, 6, 29, 0, 50},
                                           RealSet{"sourishg_fisheye_stereo/imgs", "right", 9, 6, 29, 0, 50},
                                           RealSet{"camodocal_fisheye/images", "img", 9, 6, 63, 1, 50},
                                           RealSet{"ocam/Fisheye1", "Fisheye1", 8, 6, 15, 0, 46},
                                           RealSet{"ocam/Fisheye190deg", "Fisheye190deg", 7, 6, 8, 1, 28},
                                           RealSet{"ocam/Fisheye190deg", "Fisheye190deg", 6, 5, 8, 1, 25},
                                           RealSet{"opencv_stereo_chess", "left", 9, 6, 13, 0, 54},
                                           RealSet{"opencv_stereo_chess", "right", 9, 6, 13, 0, 54},
                                           RealSet{"boofcv_stereo/Bumblebee2_Chess", "left", 6, 4, 11, 0, 24},
                                           RealSet{"boofcv_stereo/Bumblebee2_Chess", "right", 6, 4, 11, 0, 24},
                                           RealSet{"procam_virtual_dots", "white_capture", 9, 7, 5, 0, 63}));

}  // namespace
}  // namespace raybundle
