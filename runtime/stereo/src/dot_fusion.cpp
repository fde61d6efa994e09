// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/dot_fusion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "require.hpp"

namespace raybundle {
namespace {

constexpr int kNeighbours = 8;   // of a dot: those around it in a grid
constexpr int kLeastAgreed = 4;  // one more than a plane needs
constexpr double kSigmaFloor_px = 1e-3;

const DotFusionOptions& checked(ImageSize size, const DotFusionOptions& options) {
  require(size.width > 0 && size.height > 0, "an image that dots lie in has pixels");
  require(options.reach_px >= 1 && options.ring_px >= 1, "the reach and the ring of dots are at least 1 px");
  require(options.most_slope >= 0 && options.bend >= 0 && options.like_grey >= 0 && options.gate_sigmas > 0 &&
              options.contradict_sigmas > 0,
          "slope, bend, likeness and sigmas of dot fusion are not negative");
  require(options.most_dots >= 0, "the number of dots is not negative");
  return options;
}

// Median of eight pixels around a dot, or as many as the image has.
int grey_around(GreyView image, const AnchorDot& dot, double ring_px) {
  std::array<int, 8> greys;
  greys.fill(256);  // beyond any grey: those that the image lacks come last
  int count = 0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      const auto u = static_cast<int>(std::lround(dot.u_px + x * ring_px));
      const auto v = static_cast<int>(std::lround(dot.v_px + y * ring_px));
      if ((x == 0 && y == 0) || u < 0 || v < 0 || u >= image.width || v >= image.height) continue;
      greys[static_cast<std::size_t>(count++)] = image.at(u, v);
    }
  }
  std::ranges::sort(greys);
  return greys[static_cast<std::size_t>(count / 2)];
}

// A dot as seen from another one.
struct Neighbour {
  double du, dv, r2;
  double disparity_px, variance;
};

// A dot, first, and its nearest neighbours in the order of their distance.
struct Neighbours {
  std::array<Neighbour, kNeighbours + 1> all{};
  std::size_t count = 0;

  void insert(const Neighbour& neighbour) {
    if (count == all.size() && all.back().r2 <= neighbour.r2) return;
    std::size_t at = std::min(count, all.size() - 1);  // the farthest falls out
    for (; at > 0 && all[at - 1].r2 > neighbour.r2; --at) all[at] = all[at - 1];
    all[at] = neighbour;
    count = std::min(count + 1, all.size());
  }
};

// Those that agree with a plane, a bit for each.
struct Agreement {
  unsigned who = 0;
  int number = 0;
  double slope = 0.0;
};

// Who agrees with the plane through the first dot and two more; nobody when they are nearly in a line, or too steep.
Agreement agreement(const Neighbours& dots, std::size_t i, std::size_t j, double most_slope, double gate_sigmas) {
  Agreement result;
  const Neighbour &o = dots.all[0], &p = dots.all[i], &q = dots.all[j];
  const double area = p.du * q.dv - q.du * p.dv;
  if (std::abs(area) <= 0.25 * std::sqrt(p.r2 * q.r2)) return result;
  const double to_p = p.disparity_px - o.disparity_px, to_q = q.disparity_px - o.disparity_px;
  result.slope = std::hypot(to_p * q.dv - to_q * p.dv, to_q * p.du - to_p * q.du) / std::abs(area);
  if (result.slope > most_slope) return result;
  for (std::size_t k = 0; k < dots.count; ++k) {
    const Neighbour& n = dots.all[k];
    const double of_p = (n.du * q.dv - q.du * n.dv) / area;
    const double of_q = (p.du * n.dv - n.du * p.dv) / area;
    const double of_o = 1.0 - of_p - of_q;
    const double error = n.disparity_px - (o.disparity_px + of_p * to_p + of_q * to_q);
    const double variance = n.variance + of_o * of_o * o.variance + of_p * of_p * p.variance + of_q * of_q * q.variance;
    if (error * error > gate_sigmas * gate_sigmas * variance) continue;
    result.who |= 1U << k;
    ++result.number;
  }
  return result;
}

// The plane through the first dot and two more with which most agree; of equal ones the least steep: in a grid of dots,
// two columns on both sides of a step lie in one plane as well.
Agreement best_agreement(const Neighbours& dots, double most_slope, double gate_sigmas) {
  Agreement best;
  for (std::size_t i = 1; i < dots.count; ++i) {
    for (std::size_t j = i + 1; j < dots.count; ++j) {
      const Agreement found = agreement(dots, i, j, most_slope, gate_sigmas);
      const bool better = found.number > best.number || (found.number == best.number && found.slope < best.slope);
      if (found.number >= kLeastAgreed && better) best = found;
    }
  }
  return best;
}

}  // namespace

std::optional<AnchorDot> anchor_dot(const Rectification& pair, const Eigen::Vector3d& x_in_left,
                                    const Eigen::Matrix3d& covariance_m2) {
  constexpr double kPart = 1e-3;  // of the distance: for the derivative
  const Eigen::Vector3d x = pair.rectified_from_left * x_in_left, ray = x_in_left.normalized();
  const bool pinhole = pair.camera.projection == RectifiedProjection::kPinhole;
  const double distance = pinhole ? x.z() : x.norm();
  if (!(distance > 0.0)) return std::nullopt;
  const auto pixel = pair.camera.pixel_from_ray(x);
  if (!pixel || !pair.camera.contains(*pixel)) return std::nullopt;
  const auto disparity = [&](double times) {
    return disparity_from_distance(pair.camera, pair.baseline_m, pixel->x(), times * distance);
  };
  const double per_part = (disparity(1 - kPart) - disparity(1 + kPart)) / (2 * kPart);
  const double sigma_part = std::sqrt(ray.dot(covariance_m2 * ray)) / x.norm();
  return AnchorDot{pixel->x(), pixel->y(), disparity(1.0), std::abs(per_part) * sigma_part};
}

DotFusion::DotFusion(ImageSize size, const DotFusionOptions& options, std::span<const float> calibration_sigma_px)
    : size_(size),
      options_(checked(size, options)),
      columns_(static_cast<int>(size.width / options.reach_px) + 1),
      rows_(static_cast<int>(size.height / options.reach_px) + 1),
      cells_(static_cast<std::size_t>(columns_) * rows_),
      calibration_sigma_px_(calibration_sigma_px.begin(), calibration_sigma_px.end()) {
  const std::size_t pixels = static_cast<std::size_t>(size.width) * size.height;
  require(calibration_sigma_px.empty() || calibration_sigma_px.size() == pixels,
          "the calibration's sigma is for another number of pixels");
  calibration_sigma_px_.resize(pixels);
  dots_.reserve(static_cast<std::size_t>(options.most_dots));
  disparity_px_.resize(pixels);
  sigma_px_.resize(pixels);
  source_.resize(pixels);
}

// All dots of the cells around a place: those within reach are among them.
template <typename Visit>
void DotFusion::near(double u, double v, Visit visit) const {
  const auto column = static_cast<int>(u / options_.reach_px);
  const auto row = static_cast<int>(v / options_.reach_px);
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
      for (int i = cells_[static_cast<std::size_t>(y) * columns_ + x]; i >= 0;) {
        const Plane& plane = dots_[static_cast<std::size_t>(i)];
        visit(plane);
        i = plane.next;
      }
    }
  }
}

void DotFusion::place(GreyView left, std::span<const AnchorDot> dots) {
  std::fill(cells_.begin(), cells_.end(), -1);
  dots_.clear();
  for (const AnchorDot& dot : dots) {
    const bool usable = dot.u_px >= 0 && dot.v_px >= 0 && dot.u_px <= size_.width - 1 && dot.v_px <= size_.height - 1 &&
                        dot.sigma_px > 0 && dot.disparity_px > 0 && std::isfinite(dot.sigma_px) &&
                        std::isfinite(dot.disparity_px);
    if (!usable || dots_.size() == dots_.capacity()) continue;
    int& cell = cells_[static_cast<std::size_t>(dot.v_px / options_.reach_px) * columns_ +
                       static_cast<std::size_t>(dot.u_px / options_.reach_px)];
    Plane plane;
    plane.dot = dot;
    plane.grey = grey_around(left, dot, options_.ring_px);
    plane.next = cell;
    cell = static_cast<int>(dots_.size());
    dots_.push_back(plane);
  }
}

void DotFusion::fit(Plane& plane) {
  Neighbours dots;
  near(plane.dot.u_px, plane.dot.v_px, [&](const Plane& other) {
    if (std::abs(other.grey - plane.grey) > options_.like_grey) return;
    const double du = other.dot.u_px - plane.dot.u_px;
    const double dv = other.dot.v_px - plane.dot.v_px;
    const double r2 = du * du + dv * dv;
    if (r2 > options_.reach_px * options_.reach_px) return;
    const double bent = 0.5 * options_.bend * r2;
    const double sigma = std::max(other.dot.sigma_px, kSigmaFloor_px);
    dots.insert({du, dv, r2, other.dot.disparity_px, sigma * sigma + bent * bent});
  });
  const Agreement best = best_agreement(dots, options_.most_slope, options_.gate_sigmas);
  if (best.number == 0) return;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < dots.count; ++k) {
    if ((best.who >> k & 1U) == 0) continue;
    const Neighbour& n = dots.all[k];
    const Eigen::Vector3d row(1.0, n.du, n.dv);
    information += row * row.transpose() / n.variance;
    right += row * (n.disparity_px / n.variance);
  }
  plane.covariance = information.inverse();
  plane.disparity_px = plane.covariance * right;
  plane.agreed = true;
}

bool DotFusion::fill(int u, int v, int grey, float& disparity_px, float& sigma_px) const {
  std::array<const Plane*, 4> nearest{};
  std::array<double, 4> nearest_r2{};
  near(u, v, [&](const Plane& plane) {
    const double du = plane.dot.u_px - u, dv = plane.dot.v_px - v;
    const double r2 = du * du + dv * dv;
    const std::size_t quadrant = (du >= 0 ? 1U : 0U) + (dv >= 0 ? 2U : 0U);
    if (r2 > options_.reach_px * options_.reach_px) return;
    if (nearest[quadrant] != nullptr && nearest_r2[quadrant] <= r2) return;
    nearest[quadrant] = &plane;
    nearest_r2[quadrant] = r2;
  });
  std::array<double, 4> value{}, variance{};
  int count = 0;
  double weights = 0.0, mean = 0.0, sigma = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (nearest[k] == nullptr) continue;
    const Plane& plane = *nearest[k];
    if (!plane.agreed || std::abs(plane.grey - grey) > options_.like_grey) return false;
    const auto at = static_cast<std::size_t>(count++);
    const double du = u - plane.dot.u_px, dv = v - plane.dot.v_px, bent = 0.5 * options_.bend * nearest_r2[k];
    value[at] = plane.at(du, dv);
    variance[at] = plane.variance(du, dv) + bent * bent;
    for (std::size_t j = 0; j < at; ++j) {
      const double error = value[at] - value[j];
      const double gate = options_.gate_sigmas;
      if (error * error > gate * gate * (variance[at] + variance[j])) return false;
    }
    weights += 1.0 / variance[at];
    mean += value[at] / variance[at];
    sigma += 1.0 / std::sqrt(variance[at]);
  }
  if (count < 3 || mean <= 0) return false;
  disparity_px = static_cast<float>(mean / weights);
  sigma_px = static_cast<float>(sigma / weights);
  return true;
}

// Takes out the match that the dot lies on.
int DotFusion::contradict(const Plane& plane) {
  int taken_out = 0;
  const auto u0 = static_cast<int>(plane.dot.u_px), v0 = static_cast<int>(plane.dot.v_px);
  for (int v = v0; v <= std::min(v0 + 1, size_.height - 1); ++v) {
    for (int u = u0; u <= std::min(u0 + 1, size_.width - 1); ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * size_.width + u;
      if (source_[i] != static_cast<std::uint8_t>(DisparitySource::kMatched)) continue;
      const double du = u - plane.dot.u_px, dv = v - plane.dot.v_px;
      const double error = disparity_px_[i] - plane.at(du, dv);
      const double variance = std::pow(static_cast<double>(sigma_px_[i]), 2) +
                              std::pow(static_cast<double>(calibration_sigma_px_[i]), 2) + plane.variance(du, dv);
      if (error * error <= options_.contradict_sigmas * options_.contradict_sigmas * variance) continue;
      source_[i] = static_cast<std::uint8_t>(DisparitySource::kContradicted);
      disparity_px_[i] = sigma_px_[i] = 0.0F;
      ++taken_out;
    }
  }
  return taken_out;
}

FusedView DotFusion::fuse(GreyView left, const DisparityView& dense, std::span<const AnchorDot> dots) {
  FusedView out;
  place(left, dots);
  for (Plane& plane : dots_) fit(plane);
  const auto [width, height] = size_;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * width + u;
      const auto match = static_cast<Match>(dense.match.at(u, v));
      disparity_px_[i] = dense.disparity_px.at(u, v);
      sigma_px_[i] = dense.sigma_px.at(u, v);
      DisparitySource source = match == Match::kMatched ? DisparitySource::kMatched : DisparitySource::kNone;
      if (match != Match::kMatched && match != Match::kUncovered && !dots_.empty() &&
          fill(u, v, left.at(u, v), disparity_px_[i], sigma_px_[i])) {
        source = DisparitySource::kDots;
        ++out.filled;
      }
      source_[i] = static_cast<std::uint8_t>(source);
    }
  }
  for (const Plane& plane : dots_) {
    if (plane.agreed) out.contradicted += contradict(plane);
  }
  out.disparity_px = {disparity_px_.data(), width, height, width};
  out.sigma_px = {sigma_px_.data(), width, height, width};
  out.source = {source_.data(), width, height, width};
  return out;
}

}  // namespace raybundle
