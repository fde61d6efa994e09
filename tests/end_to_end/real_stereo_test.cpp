// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// Stereo of real pairs against the corners of boards that the calibration has not seen: rows, and dense disparities.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "program.hpp"
#include "raybundle/geometry/quantile.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/io/observations_file.hpp"
#include "raybundle/stereo/rectification.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

struct RealPairs {
  std::string folder, target, model, images, some;  // `some`: of the images, those that calibrate
  double most_px = 0.1;
};
void PrintTo(const RealPairs& pairs, std::ostream* out) { *out << pairs.folder; }

// Where each corner is in the rectified images: by frame and point, by camera.
using RectifiedCorners = std::map<std::pair<int, int>, std::map<int, Eigen::Vector2d>>;

RectifiedCorners rectified_corners(const Rectification& pair, const Calibration& calibration,
                                   const CalibrationProblem& problem) {
  RectifiedCorners corners;
  for (const TargetView& view : problem.views) {
    const auto& camera = calibration.cameras[static_cast<std::size_t>(view.camera)].camera;
    const auto& rotation = view.camera == 0 ? pair.rectified_from_left : pair.rectified_from_right;
    for (const Observation& corner : view.observations) {
      const auto ray = ray_from_pixel(camera, corner.pixel);
      if (!ray) continue;
      const auto pixel = pair.camera.pixel_from_ray(rotation * *ray);
      if (pixel) corners[{view.frame, corner.point_id}][view.camera] = *pixel;
    }
  }
  std::erase_if(corners, [](const auto& corner) { return corner.second.size() != 2; });
  return corners;
}

// Differences of the rows of each corner in both rectified images, by frame, without the frames that calibrated.
std::map<int, std::vector<double>> row_differences(const RectifiedCorners& corners, const CalibrationProblem& problem,
                                                   const std::set<std::string>& seen) {
  std::map<int, std::vector<double>> differences;
  for (const auto& [corner, pixel] : corners) {
    if (seen.contains(problem.frames[static_cast<std::size_t>(corner.first)])) continue;
    differences[corner.first].push_back(pixel.at(0).y() - pixel.at(1).y());
  }
  return differences;
}

// Frames whose board has one pose for both cameras: it did not move between the exposures
// (docs/decisions/0003-ties.md).
std::set<std::string> tied_frames(const nlohmann::json& report) {
  std::map<std::string, int> poses;
  for (const nlohmann::json& pose : report.at("poses")) ++poses[pose.at("frame").get<std::string>()];
  std::set<std::string> tied;
  for (const auto& [frame, count] : poses) {
    if (count == 1) tied.insert(frame);
  }
  return tied;
}

struct RealStereo : ::testing::TestWithParam<RealPairs> {};

TEST_P(RealStereo, RowsOfBoardsThatTheCalibrationHasNotSeenAgree) {
  const RealPairs& pairs = GetParam();
  RAYBUNDLE_NEEDS_DATA(pairs.folder);
  const fs::path folder = fresh_folder();
  const std::string images = (real_data(pairs.folder)).string() + "/";
  const auto cameras = [&](const std::string& pattern) {
    return std::vector<std::string>{"--target", pairs.target,
                                    "--camera", "left=" + images + "left" + pattern,
                                    "--camera", "right=" + images + "right" + pattern};
  };
  const auto calibrated_with = [&](const std::string& pattern) {
    std::vector<std::string> flags = cameras(pattern);
    flags.insert(flags.end(), {"--model", pairs.model});
    return calibrate(folder, flags);
  };
  const std::set<std::string> tied = tied_frames(calibrated_with(pairs.images));
  const nlohmann::json report = calibrated_with(pairs.some);
  detect(folder, cameras(pairs.images));
  const Calibration calibration = read_calibration(folder / "out" / "calibration.json").calibration;
  const CalibrationProblem problem = read_observations(folder / "observations.json").problem;
  std::set<std::string> seen;
  for (const auto& [camera, frames] : corners_by_frame(report)) {
    for (const auto& [frame, corners] : frames) seen.insert(frame);
  }

  const Rectification pair = rectify(calibration.cameras.at(0), calibration.cameras.at(1));
  std::vector<double> of_tied, of_others;  // mean difference of each frame
  for (const auto& [frame, differences] :
       row_differences(rectified_corners(pair, calibration, problem), problem, seen)) {
    double mean = 0.0;
    for (const double difference : differences) mean += difference / static_cast<double>(differences.size());
    (tied.contains(problem.frames[static_cast<std::size_t>(frame)]) ? of_tied : of_others).push_back(std::abs(mean));
  }
  ASSERT_GE(of_tied.size(), 3U);
  const std::size_t tied_count = of_tied.size();
  const double tied_px = median(of_tied);
  std::cout << pairs.folder << ": rows of held-out boards differ by " << tied_px << " px in " << tied_count
            << " frames that are tied";
  if (!of_others.empty()) std::cout << ", by " << median(of_others) << " px where the board moved";
  std::cout << std::endl;
  EXPECT_LT(tied_px, pairs.most_px);
}

INSTANTIATE_TEST_SUITE_P(Data, RealStereo,
                         ::testing::Values(RealPairs{"boofcv_stereo/Bumblebee2_Chess", "chessboard:6x4:30mm",
                                                     "brown_conrady", "*.jpg", "0[1-6].jpg"},
                                           RealPairs{"opencv_stereo_chess", "chessboard:9x6:25mm", "brown_conrady",
                                                     "[0-9][0-9].jpg", "0[1-7].jpg"},
                                           RealPairs{"sourishg_fisheye_stereo/imgs", "chessboard:9x6:24.23mm",
                                                     "kannala_brandt", "*.jpg", "[12][13457].jpg"}));

// Dense disparities where corners were detected in both images, against those of the corners; and how many lie exactly
// amid two pixels, where a fraction that is fitted to the wrong costs stops.
TEST(RealStereoImages, DisparitiesAgreeWithCorners) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  const fs::path folder = fresh_folder();
  calibrate(folder, {"--target", "chessboard:9x6:25mm", "--camera", "left=" + images + "left0?.jpg", "--camera",
                     "right=" + images + "right0?.jpg", "--model", "brown_conrady"});
  detect(folder, {"--target", "chessboard:9x6:25mm", "--camera", "left=" + images + "left1?.jpg", "--camera",
                  "right=" + images + "right1?.jpg"});
  const Calibration calibration = read_calibration(folder / "out" / "calibration.json").calibration;
  const CalibrationProblem problem = read_observations(folder / "observations.json").problem;
  const ProgramRun run =
      raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(), images + "left1?.jpg",
                         images + "right1?.jpg", "-o", (folder / "points").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Rectification pair = rectify(calibration.cameras.at(0), calibration.cameras.at(1));

  std::map<int, cv::Mat> disparities;
  int matched = 0, halves = 0;
  for (std::size_t frame = 0; frame < problem.frames.size(); ++frame) {
    const fs::path path = folder / "points" / (problem.frames[frame] + "_disparity.png");
    cv::Mat disparity = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(disparity.type(), CV_16U) << path;
    for (const std::uint16_t value : cv::Mat_<std::uint16_t>(disparity)) {
      matched += value > 0;
      halves += value % 256 == 128;
    }
    disparities[static_cast<int>(frame)] = disparity;
  }
  std::vector<double> off_px;
  for (const auto& [corner, pixel] : rectified_corners(pair, calibration, problem)) {
    const cv::Mat& disparity = disparities.at(corner.first);
    const cv::Point at(static_cast<int>(std::lround(pixel.at(0).x())), static_cast<int>(std::lround(pixel.at(0).y())));
    if (!cv::Rect({}, disparity.size()).contains(at) || disparity.at<std::uint16_t>(at) == 0) continue;
    off_px.push_back(std::abs(disparity.at<std::uint16_t>(at) / 256.0 - (pixel.at(0).x() - pixel.at(1).x())));
  }
  const std::size_t count = off_px.size();
  const double typical_px = median(off_px);
  std::cout << "disparities of " << count << " corners are " << typical_px << " px off, " << 100.0 * halves / matched
            << " % lie amid two pixels" << std::endl;
  EXPECT_GE(count, 50U);  // of 216: on boards that repeat themselves many are ambiguous
  EXPECT_LT(typical_px, 0.15);
  EXPECT_LT(halves, 0.02 * matched);
}

}  // namespace
}  // namespace raybundle::testing
