// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "previews.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "image_codec.hpp"
#include "image_files.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/stereo/rectification.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kWidth_px = 560;  // of a picture
constexpr int kMostRectified_px = 900;
constexpr int kSamplesPerSide = 25;   // of the field of a rectified pair, whose picture need not end to the pixel
constexpr int kQuality = 72;          // of a JPEG
constexpr int kWorstViews = 3;        // of each camera
constexpr double kWidestHalf = 1.05;  // [rad] 60°: beyond, a plane stretches more than it shows

Json picture(const char* kind, const std::string& camera, const std::string& frame, const cv::Mat& image) {
  return {{"kind", kind},        {"camera", camera},     {"frame", frame},
          {"width", image.cols}, {"height", image.rows}, {"jpeg", base64(jpeg_from(image, kQuality))}};
}

// The image of a view, in 8 bits; empty when there is none that can be read again.
cv::Mat image_of(const TargetView& view, const ProblemCamera& camera) {
  std::error_code ignored;
  std::string reason;
  if (view.image.empty() || !std::filesystem::is_regular_file(view.image, ignored)) return {};
  cv::Mat image = read_gray(view.image, reason);
  EightBits().take({&image});
  return image.cols == camera.size.width && image.rows == camera.size.height ? image : cv::Mat();
}

// The brightness between four pixels, whose weights are whole parts of 64.
std::uint8_t brightness(const cv::Mat& image, float x, float y) {
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const int right = static_cast<int>(64 * (x - static_cast<float>(column)));
  const int down = static_cast<int>(64 * (y - static_cast<float>(row)));
  const std::uint8_t* const upper = image.data + row * image.step[0] + column;
  const std::uint8_t* const lower = upper + image.step[0];
  const int above = 64 * upper[0] + right * (upper[1] - upper[0]);
  const int below = 64 * lower[0] + right * (lower[1] - lower[0]);
  return static_cast<std::uint8_t>((64 * above + down * (below - above) + 2048) / 4096);
}

// Where a pixel comes from is looked up in every eighth row and column, and between them is nearly linear.
cv::Mat resampled(const cv::Mat& image, int width, int height,
                  const std::function<std::optional<Eigen::Vector2d>(int, int)>& source) {
  constexpr int kStep = 8;
  constexpr std::uint8_t kBeyond = 40;        // the image it is dark
  const Eigen::Vector2d nowhere(-1e6, -1e6);  // as is all that lies between it and a pixel
  const int columns = (width - 1) / kStep + 2, rows = (height - 1) / kStep + 2;
  std::vector<Eigen::Vector2f> coarse;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      coarse.push_back(source(kStep * column, kStep * row).value_or(nowhere).cast<float>());
    }
  }
  const auto most_x = static_cast<float>(image.cols - 1), most_y = static_cast<float>(image.rows - 1);
  cv::Mat result(height, width, CV_8U, cv::Scalar(kBeyond));
  for (int v = 0; v < height; ++v) {
    std::uint8_t* const to = result.ptr(v);
    const float down = static_cast<float>(v % kStep) / kStep;
    const Eigen::Vector2f* const upper = coarse.data() + v / kStep * columns;
    const auto at = [&](int column) -> Eigen::Vector2f {
      return upper[column] + down * (upper[column + columns] - upper[column]);
    };
    for (int first = 0; first < width; first += kStep) {
      const Eigen::Vector2f begin = at(first / kStep), step = (at(first / kStep + 1) - begin) / kStep;
      for (int k = 0; k < std::min(kStep, width - first); ++k) {
        const float x = begin.x() + static_cast<float>(k) * step.x(), y = begin.y() + static_cast<float>(k) * step.y();
        if (x >= 0 && y >= 0 && x < most_x && y < most_y) to[first + k] = brightness(image, x, y);
      }
    }
  }
  return result;
}

// Area by area where pixels would be left out between others.
cv::Mat resized(const cv::Mat& image, int width, int height) {
  cv::Mat result;
  const bool all_count = image.cols < 2 * width && image.rows < 2 * height;
  cv::resize(image, result, cv::Size(width, height), 0, 0, all_count ? cv::INTER_LINEAR : cv::INTER_AREA);
  return result;
}

// An ideal camera on the same axis, whose image shows the used field or what of it a plane can show.
struct Plane {
  double focal_px;
  int width, height;

  Plane(const Camera& camera, double seen_to_rad) : width(kWidth_px) {
    const double half = std::tan(std::clamp(seen_to_rad, 0.1, kWidestHalf));
    const double aspect = static_cast<double>(camera.size.height) / camera.size.width;
    height = static_cast<int>(std::lround(kWidth_px * aspect));
    focal_px = 0.5 * std::hypot(width, height) / half;
  }
  Eigen::Vector3d ray(double u, double v) const {
    return {(u - 0.5 * (width - 1)) / focal_px, (v - 0.5 * (height - 1)) / focal_px, 1.0};
  }
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector3d& ray) const {
    if (ray.z() < 0.1) return std::nullopt;
    return Eigen::Vector2d(focal_px * ray.x() / ray.z() + 0.5 * (width - 1),
                           focal_px * ray.y() / ray.z() + 0.5 * (height - 1));
  }
  bool shows(const Eigen::Vector3d& ray) const {
    const auto at = pixel(ray);
    return at && at->minCoeff() >= 0 && at->x() < width && at->y() < height;
  }
};

// From the first to the last used corner of each row of the board: what lies between has to lie on it.
Json straight_lines(const Camera& camera, const Plane& plane, const Target& target, const TargetView& view,
                    const ViewResult& result) {
  struct Row {
    double least = 1e9, most = -1e9;
    Eigen::Vector2d first, last;
  };
  std::map<long, Row> rows;  // by y on the board, in micrometres
  for (std::size_t i = 0; i < view.observations.size(); ++i) {
    if (result.fates[i] != ObservationFate::kUsed) continue;
    const auto ray = ray_from_pixel(camera, view.observations[i].pixel);
    const auto pixel = ray ? plane.pixel(*ray) : std::nullopt;
    if (!pixel) continue;
    const Eigen::Vector3d& x = target.find(view.observations[i].point_id)->x_in_target;
    Row& row = rows[std::lround(1e6 * x.y())];
    if (x.x() < row.least) row.first = *pixel, row.least = x.x();
    if (x.x() > row.most) row.last = *pixel, row.most = x.x();
  }
  Json lines = Json::array();
  for (const auto& [y, row] : rows) {
    if (row.most > row.least) lines.push_back({row.first.x(), row.first.y(), row.last.x(), row.last.y()});
  }
  return lines;
}

// Calls use(view, observation) for the used corners of a camera.
void for_each_used(const CalibrationProblem& problem, const CalibrationResult& result, const std::string& camera,
                   const std::function<void(int, const Observation&)>& use) {
  for (int v = 0; v < static_cast<int>(problem.views.size()); ++v) {
    const TargetView& view = problem.views[v];
    if (problem.cameras[view.camera].name != camera || result.views[v].pose < 0) continue;
    for (std::size_t i = 0; i < view.observations.size(); ++i) {
      if (result.views[v].fates[i] == ObservationFate::kUsed) use(v, view.observations[i]);
    }
  }
}

void add_undistorted(const CalibrationProblem& problem, const CalibrationResult& result, const RigCamera& camera,
                     Json& pictures) {
  double seen_to = 0.0;
  std::vector<std::pair<int, Eigen::Vector3d>> rays;  // of used corners, with their views
  for_each_used(problem, result, camera.name, [&](int v, const Observation& observation) {
    const auto ray = ray_from_pixel(camera.camera, observation.pixel);
    if (!ray) return;
    rays.emplace_back(v, *ray);
    seen_to = std::max(seen_to, angle_off_axis(*ray));
  });
  const Plane plane(camera.camera, seen_to);
  std::vector<double> sums(problem.views.size(), 0.0);  // many corners far off the axis, and in the picture, show most
  for (const auto& [v, ray] : rays) {
    if (plane.shows(ray)) sums[v] += angle_off_axis(ray);
  }
  const auto best = static_cast<int>(std::ranges::max_element(sums) - sums.begin());
  if (sums.empty() || sums[best] == 0.0) return;
  const TargetView& view = problem.views[best];
  const cv::Mat image = image_of(view, problem.cameras[view.camera]);
  if (image.empty()) return;
  const cv::Mat flat = resampled(image, plane.width, plane.height,
                                 [&](int u, int v) { return pixel_from_ray(camera.camera, plane.ray(u, v)); });
  const std::string& frame = problem.frames[view.frame];
  pictures.push_back(picture("distorted", camera.name, frame, resized(image, plane.width, plane.height)));
  pictures.push_back(picture("undistorted", camera.name, frame, flat));
  pictures.back()["lines"] =
      straight_lines(camera.camera, plane, problem.targets[view.target], view, result.views[best]);
}

void add_worst_views(const CalibrationProblem& problem, const CalibrationResult& result, const std::string& camera,
                     Json& pictures) {
  std::vector<int> views;
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    if (problem.cameras[problem.views[v].camera].name == camera) views.push_back(static_cast<int>(v));
  }
  const auto badness = [&](int v) { return result.views[v].pose < 0 ? 1e9 : result.views[v].rms_px; };
  std::ranges::stable_sort(views, std::ranges::greater{}, badness);
  int count = 0;
  for (const int v : views) {
    if (count == kWorstViews) break;
    const TargetView& view = problem.views[v];
    const cv::Mat image = image_of(view, problem.cameras[view.camera]);
    if (image.empty()) continue;
    const int width = std::min(kWidth_px, image.cols), height = std::max(1, width * image.rows / image.cols);
    pictures.push_back(picture("view", camera, problem.frames[view.frame], resized(image, width, height)));
    ++count;
  }
}

// Both images of the frame that shows the board best to both, side by side.
void add_rectified(const CalibrationProblem& problem, const RigCamera& left, const RigCamera& right, Json& pictures) {
  std::map<std::pair<int, int>, const TargetView*> seen_by_left;
  const TargetView *best_left = nullptr, *best_right = nullptr;
  for (const TargetView& view : problem.views) {
    if (problem.cameras[view.camera].name == left.name) seen_by_left[{view.frame, view.target}] = &view;
  }
  std::size_t most = 0;
  for (const TargetView& view : problem.views) {
    const auto other = seen_by_left.find({view.frame, view.target});
    if (problem.cameras[view.camera].name != right.name || other == seen_by_left.end()) continue;
    const std::size_t both = std::min(view.observations.size(), other->second->observations.size());
    if (both > most) best_left = other->second, best_right = &view, most = both;
  }
  if (!best_left) return;
  const cv::Mat image_left = image_of(*best_left, problem.cameras[best_left->camera]);
  const cv::Mat image_right = image_of(*best_right, problem.cameras[best_right->camera]);
  if (image_left.empty() || image_right.empty()) return;
  const Rectification pair =
      rectify(left, right, {.width_px = kMostRectified_px / 2, .samples_per_side = kSamplesPerSide});
  const auto half = [&](const RigCamera& camera, const Eigen::Quaterniond& rectified_from_camera,
                        const cv::Mat& image) {
    return resampled(image, pair.camera.size.width, pair.camera.size.height, [&](int u, int v) {
      const auto ray = pair.camera.ray_from_pixel({u, v});
      return ray ? pixel_from_ray(camera.camera, rectified_from_camera.conjugate() * *ray) : std::nullopt;
    });
  };
  cv::Mat both;
  cv::hconcat(half(left, pair.rectified_from_left, image_left), half(right, pair.rectified_from_right, image_right),
              both);
  pictures.push_back(picture("rectified", left.name + " and " + right.name, problem.frames[best_left->frame], both));
  Json lines = Json::array();
  for (int k = 1; k < 10; ++k) lines.push_back({0, k * both.rows / 10, both.cols - 1, k * both.rows / 10});
  pictures.back()["lines"] = lines;
}

}  // namespace

ReportSection pictures_section(const CalibrationProblem& problem, const CalibrationResult& result, int threads) {
  const std::vector<RigCamera>& cameras = result.calibration.cameras;
  std::vector<std::function<void(Json&)>> sets;  // of pictures
  for (const RigCamera& camera : cameras) {
    sets.push_back([&](Json& pictures) { add_worst_views(problem, result, camera.name, pictures); });
    sets.push_back([&](Json& pictures) { add_undistorted(problem, result, camera, pictures); });
  }
  for (std::size_t c = 1; c < cameras.size(); ++c) {
    sets.push_back([&, c](Json& pictures) {
      try {
        add_rectified(problem, cameras[0], cameras[c], pictures);
      } catch (const Error&) {  // cameras that look apart, or stand behind each other, make no pair
      }
    });
  }
  std::vector<Json> made(sets.size(), Json::array());
  for_each_index(sets.size(), threads, [&](std::size_t i) { sets[i](made[i]); });
  Json pictures = Json::array();
  for (Json& set : made) std::ranges::move(set, std::back_inserter(pictures));
  return {"pictures", pictures.dump()};
}

}  // namespace raybundle::apps
