// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "saddle.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "raybundle/geometry/target_clones.hpp"
#include "saddle_fit.hpp"

namespace raybundle {
namespace {

constexpr double kLargestRadius_px = 11.0;
constexpr double kNoise_grey = 2.5;  // noise against which the priors are weighed

struct Shape {
  Eigen::Matrix2d window_from_pixel;  // the window is |u|, |v| < 1, or the unit disc when round
  bool round = false;
  int stride = 1;      // [px] between samples: large windows for far starts
  double half_px = 0;  // the shortest half-width
  SaddleBends bends;
  const Saddle* known = nullptr;         // an earlier fit
  bool doubtful = false, rough = false;  // as SaddleWindow
};

RAYBUNDLE_TARGET_CLONES void take_samples(const cv::Mat& gray, const Eigen::Vector2d& centre, const Shape& shape,
                                          SaddleSamples& samples) {
  const Eigen::Matrix2d pixel_from_window = shape.window_from_pixel.inverse();
  Eigen::Vector2d reach = pixel_from_window.cwiseAbs().rowwise().sum();
  if (shape.round) reach = pixel_from_window.rowwise().norm();
  const int left = std::max(0, static_cast<int>(std::ceil(centre.x() - reach.x())));
  const int right = std::min(gray.cols - 1, static_cast<int>(std::floor(centre.x() + reach.x())));
  const int top = std::max(0, static_cast<int>(std::ceil(centre.y() - reach.y())));
  const int bottom = std::min(gray.rows - 1, static_cast<int>(std::floor(centre.y() + reach.y())));
  const Eigen::Matrix2f window_from_pixel = shape.window_from_pixel.cast<float>();
  constexpr int kMostColumns = 48;  // a window's sides are 22 samples long at most
  const int columns = std::min(kMostColumns, (right - left) / shape.stride + 1);
  float at_x[kMostColumns], u_of_x[kMostColumns], v_of_x[kMostColumns];
  for (int i = 0; i < columns; ++i) {
    at_x[i] = static_cast<float>(left + i * shape.stride - centre.x());
    u_of_x[i] = window_from_pixel(0, 0) * at_x[i];
    v_of_x[i] = window_from_pixel(1, 0) * at_x[i];
  }
  samples.size = 0;
  samples.weights = 0;
  for (int y = top; y <= bottom; y += shape.stride) {
    constexpr float kLeastWeight = 0.02F;
    const uchar* row = gray.ptr<uchar>(y) + left;
    const float at_y = static_cast<float>(y - centre.y());
    const float u_of_y = window_from_pixel(0, 1) * at_y, v_of_y = window_from_pixel(1, 1) * at_y;
    float root_weight[kMostColumns];
    for (int i = 0; i < columns; ++i) {
      const float u = u_of_x[i] + u_of_y, v = v_of_x[i] + v_of_y;
      const float fall_u = 1 - u * u, fall_v = 1 - v * v;
      const float weight = shape.round ? fall_u - v * v : fall_u * fall_v;
      const bool inside = (fall_u > 0) & (fall_v > 0) & (weight > kLeastWeight);
      root_weight[i] = std::sqrt(inside ? weight : 0);
    }
    for (int i = 0; i < columns; ++i) {
      samples.add(at_x[i], at_y, row[i * shape.stride], root_weight[i]);
    }
  }
  samples.pad();
}

/// Unit vectors along the two edges.
struct Edges {
  float a_x, a_y, b_x, b_y;
  explicit Edges(const SaddleVector& parameters)
      : a_x(static_cast<float>(std::cos(parameters[kAngleA]))),
        a_y(static_cast<float>(std::sin(parameters[kAngleA]))),
        b_x(static_cast<float>(std::cos(parameters[kAngleB]))),
        b_y(static_cast<float>(std::sin(parameters[kAngleB]))) {}
  float beside_a(float x, float y) const { return a_x * y - a_y * x; }
  float beside_b(float x, float y) const { return b_x * y - b_y * x; }
};

/// Which of up to four sectors each sample lies in, and how much it counts there.
struct Sectors {
  int sector[SaddleSamples::kMost];
  float weight[SaddleSamples::kMost];
};

using Four [[gnu::vector_size(4 * sizeof(float))]] = float;  // one of each sector
struct SectorSums {
  Four grey = {};
  Four weight = {1e-9F, 1e-9F, 1e-9F, 1e-9F};  // an empty sector has a mean, too
};

/// Sums in the samples' order: to all sectors but one 0 is added, which takes no branch.
SectorSums sums_of(const SaddleSamples& samples, const Sectors& sectors) {
  using Mask [[gnu::vector_size(4 * sizeof(float))]] = std::int32_t;
  static constexpr Mask kOnly[4] = {{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, -1}};
  SectorSums sums;
  for (int i = 0; i < samples.size; ++i) {
    const Mask only = kOnly[sectors.sector[i]];
    const float weight = sectors.weight[i], grey = weight * samples.grey[i];
    sums.grey += reinterpret_cast<Four>(only & reinterpret_cast<Mask>(Four{grey, grey, grey, grey}));
    sums.weight += reinterpret_cast<Four>(only & reinterpret_cast<Mask>(Four{weight, weight, weight, weight}));
  }
  return sums;
}

/// Start values of the linear parameters, from the samples' signs.
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] void set_levels(const SaddleSamples& samples, SaddleVector& parameters) {
  const Edges edges(parameters);
  Sectors sectors;
  for (int i = 0, n = samples.padded(); i < n; ++i) {
    const float x = samples.x[i], y = samples.y[i];
    sectors.sector[i] = edges.beside_a(x, y) * edges.beside_b(x, y) < 0;
    sectors.weight[i] = samples.root_weight[i] * samples.root_weight[i];
  }
  const auto& [sum, weight] = sums_of(samples, sectors);
  const float dark_level = sum[0] / weight[0];
  const float bright_level = sum[1] / weight[1];
  parameters[kBase] = 0.5 * (dark_level + bright_level);
  parameters[kAmplitude] = 0.5 * (bright_level - dark_level);
}

Saddle saddle_of(const SaddleFit& fit, const Eigen::Vector2d& start, int samples) {
  Saddle saddle;
  const SaddleVector& parameters = fit.parameters;
  saddle.pixel = start + parameters.head<2>();
  saddle.edge_a = {std::cos(parameters[kAngleA]), std::sin(parameters[kAngleA])};
  saddle.edge_b = {std::cos(parameters[kAngleB]), std::sin(parameters[kAngleB])};
  if (parameters[kAmplitude] < 0) saddle.edge_a = std::exchange(saddle.edge_b, -saddle.edge_a);
  saddle.contrast = 2 * std::abs(parameters[kAmplitude]);
  saddle.blur_px = std::exp(parameters[kLogBlur]);
  const double mean_square = fit.squares / fit.weights;
  const double spare = std::max(0.2, 1.0 - static_cast<double>(kSaddleParameters) / samples);
  saddle.misfit = std::sqrt(mean_square / spare) / std::max(saddle.contrast, 1e-6);

  const double variance_grey = mean_square / spare + 1.0 / 12;  // never below the rounding to whole grey values
  // What the fit's own residuals do not show: the pixel grid, and the print and a blur that is not as Gaussian as the
  // model's. On real boards corners scatter about their neighbours by .04 of the blur, whether it is .4 or 1.4 px.
  constexpr double kFloor_px = 0.015;
  constexpr double kFloorPerBlur = 0.04;
  const double unseen_px = std::hypot(kFloor_px, kFloorPerBlur * saddle.blur_px);
  const double seen_px = std::sqrt(variance_grey * fit.variance_px2);
  saddle.sigma_px = std::hypot(seen_px, unseen_px);
  return saddle;
}

/// By how much the darker bright sector is brighter than the brighter dark one, as a part of the contrast; negative
/// when the sectors do not alternate.
///
/// @param margin_px  samples nearer to an edge count less
RAYBUNDLE_TARGET_CLONES [[gnu::flatten]] double alternation(const SaddleSamples& samples,
                                                            const SaddleVector& parameters, double margin_px) {
  const Edges edges(parameters);
  const Eigen::Vector2f corner = parameters.head<2>().cast<float>();
  const float corner_x = corner.x(), corner_y = corner.y(), sharp = static_cast<float>(1 / margin_px);
  Sectors sectors;
  for (int i = 0, n = samples.padded(); i < n; ++i) {
    const float x = samples.x[i] - corner_x, y = samples.y[i] - corner_y;
    const float side_a = edges.beside_a(x, y), side_b = edges.beside_b(x, y);
    sectors.sector[i] = 2 * (side_a * side_b < 0) + (side_a < 0);
    sectors.weight[i] = samples.root_weight[i] * samples.root_weight[i] *
                        std::min(1.0F, std::min(std::abs(side_a), std::abs(side_b)) * sharp);
  }
  const auto& [sum, weight] = sums_of(samples, sectors);
  const double dark[2] = {sum[0] / weight[0], sum[1] / weight[1]};
  const double bright[2] = {sum[2] / weight[2], sum[3] / weight[3]};
  const double sign = parameters[kAmplitude] < 0 ? -1 : 1;
  double least = 1e9;
  for (const double d : dark) {
    for (const double b : bright) least = std::min(least, sign * (b - d));
  }
  return least / std::max(1e-6, 0.5 * sign * (bright[0] + bright[1] - dark[0] - dark[1]));
}

/// Where a fit is worth its time. Beyond the board's rim most fits fail, and those take longest.
bool worth_a_fit(const SaddleSamples& samples, const SaddleVector& parameters, double half_px) {
  constexpr double kLeastAlternation = 0.15;  // left of a corner that is a third of the half-window off
  return alternation(samples, parameters, 0.3 * half_px) > kLeastAlternation;
}

bool convincing(const Saddle& saddle, const Eigen::Vector2d& start, const Shape& shape) {
  const Eigen::Vector2d moved = shape.window_from_pixel * (saddle.pixel - start);
  const double sine = std::abs(saddle.edge_a.x() * saddle.edge_b.y() - saddle.edge_a.y() * saddle.edge_b.x());
  return saddle.pixel.allFinite() && moved.cwiseAbs().maxCoeff() < 0.6 && saddle.contrast > 6 && saddle.misfit < 0.18 &&
         sine > 0.15 && saddle.sigma_px < 0.5 && saddle.blur_px < 1.2 * shape.half_px;
}

/// The angle of `edge`, in either direction, that is the nearest to `angle`.
double nearest_angle(const Eigen::Vector2d& edge, double angle) {
  return angle + std::remainder(std::atan2(edge.y(), edge.x()) - angle, std::numbers::pi);
}

SaddleVector start_parameters(const Shape& shape, double angle_a, double angle_b) {
  SaddleVector parameters = SaddleVector::Zero();
  parameters[kAngleA] = angle_a;
  parameters[kAngleB] = angle_b;
  parameters[kLogBlur] = std::log(std::min(1.0, 0.5 * shape.half_px));
  if (shape.known == nullptr) return parameters;
  const Eigen::Vector2d along_a(std::cos(angle_a), std::sin(angle_a));
  const bool same = std::abs(shape.known->edge_a.dot(along_a)) > std::abs(shape.known->edge_b.dot(along_a));
  parameters[kAngleA] = nearest_angle(same ? shape.known->edge_a : shape.known->edge_b, angle_a);
  parameters[kAngleB] = nearest_angle(same ? shape.known->edge_b : shape.known->edge_a, angle_b);
  parameters[kLogBlur] = std::log(std::clamp(shape.known->blur_px, 0.2, shape.half_px));
  return parameters;
}

/// Fits the model; the window moves along when the corner turns out to lie off its centre.
std::optional<Saddle> fitted(const cv::Mat& gray, const Eigen::Vector2d& start, const Shape& shape, double angle_a,
                             double angle_b, double angle_sigma) {
  Eigen::Vector2d centre = start;
  SaddleVector parameters = start_parameters(shape, angle_a, angle_b);
  const double centred = shape.rough ? 0.25 : 0.05;  // half-windows that the corner may lie off the centre
  SaddleWork work;
  SaddleSamples& samples = work.samples;
  for (int round = 0;; ++round) {
    take_samples(gray, centre, shape, samples);
    if (samples.size < 16) return std::nullopt;
    if (round == 0) {
      set_levels(samples, parameters);
      if (shape.doubtful && !worth_a_fit(samples, parameters, shape.half_px)) return std::nullopt;
    }
    SaddlePriors priors;
    const auto expect = [&](int which, double mean, double sigma) {
      priors.mean[which] = mean;
      priors.weight[which] = kNoise_grey * kNoise_grey / (sigma * sigma);
    };
    const double amplitude = std::max(5.0, std::abs(parameters[kAmplitude]));
    expect(kAngleA, angle_a, angle_sigma);
    expect(kAngleB, angle_b, angle_sigma);
    expect(kLogBlur, std::log(0.9), 0.8);
    expect(kTone, 0, 0.5 * amplitude);
    expect(kShadeX, 0, 0.3 * amplitude / shape.half_px);
    expect(kShadeY, 0, 0.3 * amplitude / shape.half_px);
    const SaddleFit fit = minimise_saddle(work, parameters, priors, shape.bends, shape.window_from_pixel, shape.rough);
    const Eigen::Vector2d moved = fit.parameters.head<2>();
    if (!moved.allFinite()) return std::nullopt;
    const Saddle saddle = saddle_of(fit, centre, samples.size);
    if (round >= 2 || (shape.window_from_pixel * moved).cwiseAbs().maxCoeff() < centred) {
      // At the outer corner of a dark square three sectors are bright, and a fit alone can make up for that.
      constexpr double kLeastAlternation = 0.35;
      const bool good =
          convincing(saddle, start, shape) && alternation(samples, fit.parameters, saddle.blur_px) > kLeastAlternation;
      return good ? std::optional(saddle) : std::nullopt;
    }
    if ((shape.window_from_pixel * (saddle.pixel - start)).cwiseAbs().maxCoeff() > 1) return std::nullopt;
    centre = saddle.pixel;
    parameters = fit.parameters;
    parameters.head<2>().setZero();
  }
}

bool border_is_near(const cv::Mat& gray, const Eigen::Vector2d& pixel) {
  constexpr double kMargin_px = 1.5;
  return !(pixel.x() >= kMargin_px && pixel.y() >= kMargin_px && pixel.x() <= gray.cols - 1 - kMargin_px &&
           pixel.y() <= gray.rows - 1 - kMargin_px);
}

}  // namespace

std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, double radius_px) {
  if (border_is_near(gray, start)) return std::nullopt;
  const double radius = std::clamp(radius_px, 3.0, kLargestRadius_px);
  std::optional<SaddleRing> ring;
  for (const double part : {0.7, 0.5, 0.9}) {
    if ((ring = saddle_ring(gray, start, part * radius))) break;
  }
  if (!ring) return std::nullopt;
  Shape shape;
  shape.window_from_pixel = Eigen::Matrix2d::Identity() / radius;
  shape.round = true;
  shape.half_px = radius;
  return fitted(gray, start, shape, ring->angle_a, ring->angle_b, 0.3);
}

std::optional<Saddle> refine_saddle(const cv::Mat& gray, const Eigen::Vector2d& start, const SaddleWindow& window) {
  if (border_is_near(gray, start)) return std::nullopt;
  const double length_x = window.half_x.norm();
  const double length_y = window.half_y.norm();
  const double cross = window.half_x.x() * window.half_y.y() - window.half_x.y() * window.half_y.x();
  if (!(length_x > 0.8 && length_y > 0.8 && std::abs(cross) > 0.1 * length_x * length_y)) return std::nullopt;
  // Larger windows cost time and bring the lens's curvature, not accuracy; rough ones are a third of the work.
  const double longest_half = window.rough ? 6.0 : 11.0;
  const auto fit = [&](const Eigen::Vector2d& from, int stride) {
    const double longest = stride * longest_half;
    Eigen::Matrix2d pixel_from_window;
    pixel_from_window.col(0) = window.half_x * std::min(1.0, longest / length_x);
    pixel_from_window.col(1) = window.half_y * std::min(1.0, longest / length_y);
    Shape shape;
    shape.window_from_pixel = pixel_from_window.inverse();
    shape.stride = stride;
    shape.half_px = std::min({length_x, length_y, longest});
    shape.bends = {window.bend_x, window.bend_y};
    shape.known = window.known;
    shape.doubtful = window.doubtful;
    shape.rough = window.rough;
    const double angle_x = std::atan2(window.half_x.y(), window.half_x.x());
    const double angle_y = std::atan2(window.half_y.y(), window.half_y.x());
    return fitted(gray, from, shape, angle_x, angle_y, 0.2);
  };
  auto saddle = fit(start, 1);
  if (saddle || std::max(length_x, length_y) < 1.3 * longest_half) return saddle;
  // The cut window may have missed the corner: look further, with as many samples.
  constexpr int kFurther = 5;
  const auto coarse = fit(start, kFurther);
  return coarse ? fit(coarse->pixel, 1) : std::nullopt;
}

}  // namespace raybundle
