// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "board_render.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_file.hpp"
#include "raybundle/targets/board_picture.hpp"
#include "raybundle/targets/detect.hpp"
#include "raybundle/targets/draw.hpp"

namespace raybundle {
namespace {

constexpr int kStep_px = 240;  // of the drawn board; fine beside a pixel of the rendered image

// The drawn board as ink in its own frame; the drawing has a margin of one step all around.
testing::Print print_of(const Board& board, double step_m) {
  DrawOptions options;
  options.square_px = kStep_px;
  const std::string bytes = draw(board, DrawingFormat::kPng, options).bytes;
  const cv::Mat drawn = cv::imdecode(std::vector<uchar>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
  const BoardPicture picture = picture_of(board);
  return [=](double x, double y) {
    const Eigen::Vector2d at = picture.picture_from_target({x, y, 0.0}) / step_m + Eigen::Vector2d::Ones();
    const int column = static_cast<int>(std::floor(at.x() * kStep_px));
    const int row = static_cast<int>(std::floor(at.y() * kStep_px));
    if (column < 0 || row < 0 || column >= drawn.cols || row >= drawn.rows) return -1.0;
    return drawn.at<uchar>(row, column) / 255.0;
  };
}

struct Case {
  const char* word;
  double step_m;
  double share;   // of the board's points that must be found
  double rms_px;  // largest error allowed
};

void PrintTo(const Case& tested, std::ostream* out) { *out << tested.word; }

class RenderedBoard : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    board = board_from_word(GetParam().word);
    target = target_of(board);
    camera = start_camera(*model_named("kannala_brandt"), {1280, 960}, 480.0);
    Eigen::Vector3d low = target.points.front().x_in_target;
    Eigen::Vector3d high = low;
    for (const TargetPoint& point : target.points) {
      low = low.cwiseMin(point.x_in_target);
      high = high.cwiseMax(point.x_in_target);
    }
    // Tilted, off to one side, and near: the board reaches 60° off the axis. Boards with y up are turned to face us.
    const Eigen::Vector3d middle = 0.5 * (low + high);
    const double size = (high - low).norm();
    const bool up = picture_of(board).y_direction.y() < 0.0;
    camera_from_target.rotation =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d(0.3, 1.0, 0.1).normalized())) *
        Eigen::Quaterniond(Eigen::AngleAxisd(up ? std::numbers::pi : 0.0, Eigen::Vector3d::UnitX()));
    camera_from_target.translation =
        Eigen::Vector3d(0.25 * size, -0.05 * size, 0.55 * size) - camera_from_target.rotation * middle;
    testing::RenderOptions options;
    options.noise_grey = 2.0;
    image = testing::render_board(camera, camera_from_target, print_of(board, GetParam().step_m), options);
  }

  Eigen::Vector2d truth(int id) const {
    return pixel_from_ray(camera, camera_from_target * target.find(id)->x_in_target).value_or(Eigen::Vector2d::Zero());
  }

  // Root mean squared error, whatever symmetric labelling was chosen, and that of error over sigma.
  std::pair<double, double> errors(const std::vector<Observation>& seen) const {
    std::vector<std::vector<int>> labels{{}};
    for (const TargetPoint& point : target.points) labels[0].push_back(point.id);
    for (const TargetSymmetry& symmetry : target.symmetries) labels.push_back(symmetry.ids);
    std::pair best(1e9, 1e9);
    for (const std::vector<int>& ids : labels) {
      double squares = 0.0;
      double whitened = 0.0;
      for (const Observation& point : seen) {
        const auto place = target.find(point.point_id) - target.points.data();
        const double error = (point.pixel - truth(ids[place])).squaredNorm();
        squares += error;
        whitened += 0.5 * error / (point.sigma_px * point.sigma_px);
      }
      const auto n = static_cast<double>(seen.size());
      best = std::min(best, std::pair(std::sqrt(squares / n), std::sqrt(whitened / n)));
    }
    return best;
  }

  Board board;
  Target target;
  Camera camera;
  Rigid3 camera_from_target;
  cv::Mat image;
};

TEST_P(RenderedBoard, IsFoundThroughAFisheyeWhereItIs) {
  const Detection detection = detect(board, image);
  ASSERT_GE(static_cast<double>(detection.observations.size()),
            GetParam().share * static_cast<double>(target.points.size()))
      << detection.hint;
  const auto [rms_px, whitened] = errors(detection.observations);
  EXPECT_LT(rms_px, GetParam().rms_px);
  // Sigmas are estimates of their own: within a factor of two and a half they are honest.
  EXPECT_LT(whitened, 2.5);
  EXPECT_GT(whitened, 0.3);
  RecordProperty("rms_px", std::to_string(rms_px));
}

TEST_P(RenderedBoard, IsRefinedFromAPredictionThatIsAPixelOff) {
  std::vector<Observation> predicted;
  for (const TargetPoint& point : target.points) {
    const Eigen::Vector2d pixel = truth(point.id) + Eigen::Vector2d(point.id % 2 ? 0.8 : -0.8, 0.6);
    predicted.push_back({pixel, 1.0, point.id});
  }
  const std::vector<Observation> refined = refine_predicted(board, image, predicted);
  EXPECT_GE(static_cast<double>(refined.size()), GetParam().share * static_cast<double>(target.points.size()));
  ASSERT_FALSE(refined.empty());
  double squares = 0.0;
  for (const Observation& point : refined) squares += (point.pixel - truth(point.point_id)).squaredNorm();
  EXPECT_LT(std::sqrt(squares / static_cast<double>(refined.size())), GetParam().rms_px);
}

TEST_P(RenderedBoard, IsNotRefinedWhereThereIsNone) {
  const cv::Mat blank(image.size(), CV_8U, cv::Scalar(120));
  std::vector<Observation> predicted;
  for (const TargetPoint& point : target.points) predicted.push_back({truth(point.id), 1.0, point.id});
  EXPECT_TRUE(refine_predicted(board, blank, predicted).empty());
  EXPECT_TRUE(detect(board, blank).observations.empty());
}

INSTANTIATE_TEST_SUITE_P(Kinds, RenderedBoard,
                         ::testing::Values(Case{"charuco:9x7:20mm:15mm:DICT_5X5_1000", 0.020, 0.95, 0.10},
                                           Case{"aprilgrid:6x5:60mm:0.3", 0.060, 0.95, 0.10},
                                           Case{"aprilgrid:6x5:60mm:0.3:1bit", 0.060, 0.95, 0.10},
                                           Case{"circles:9x7:20mm", 0.020, 0.95, 0.06},
                                           Case{"asymmetric_circles:5x11:20mm", 0.020, 0.95, 0.08}));

TEST(Detect, TakesSixteenBitsAndRefusesColour) {
  const cv::Mat colour(100, 100, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_THROW(detect(Circles{4, 4, 0.02}, colour), Error);
  const cv::Mat deep(100, 100, CV_16U, cv::Scalar(4000));
  EXPECT_TRUE(detect(Circles{4, 4, 0.02}, deep).observations.empty());
}

TEST(Detect, RefusesAListOfPoints) {
  const cv::Mat gray(100, 100, CV_8U, cv::Scalar(0));
  EXPECT_THROW(detect(PointSet{}, gray), Error);
}

}  // namespace
}  // namespace raybundle
