// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/laser_dots.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "laser_dots_gates.hpp"
#include "laser_dots_peaks.hpp"

namespace raybundle {
namespace {

constexpr double kFirstSigma = 1.2;  // pixels
constexpr double kLeastSigma = 0.5, kMostSigma = 8.0;
constexpr std::size_t kWidthSpots = 60;    // that tell the usual width
constexpr std::size_t kMostPeaks = 20000;  // bounds the time on images of anything else
constexpr double kDistrust = 0.2;          // of what the reflectance's change across a spot moves it

bool in_region(const std::vector<Eigen::Vector2d>& region, const Eigen::Vector2d& pixel) {
  bool left = false, right = false;
  for (std::size_t i = 0; i < region.size(); ++i) {
    const Eigen::Vector2d side = region[(i + 1) % region.size()] - region[i], to = pixel - region[i];
    const double turn = side.x() * to.y() - side.y() * to.x();
    (turn < 0 ? left : right) |= turn != 0;
  }
  return !(left && right);
}

class Finder {
 public:
  Finder(const DotImages& images, const DotOptions& options) : images_(images), options_(options) {}

  double spot_sigma() const;
  std::vector<SpotCandidate> candidates(double sigma_px) const;
  std::vector<SpotPeak> peaks(double sigma_px, double least) const;
  void fit(SpotCandidate& candidate, const Spot& start, const SpotShape& shape, double sigma_px,
           const std::vector<const Spot*>& others) const;

 private:
  const DotImages& images_;
  const DotOptions& options_;
};

Eigen::Vector2d pixel_of(const SpotPeak& peak) { return {peak.pixel.x, peak.pixel.y}; }

SpotShape round_shape(double sigma_px, double relative_sigma) {
  return {Eigen::Matrix2d::Identity() / (sigma_px * sigma_px), relative_sigma};
}

std::vector<SpotPeak> Finder::peaks(double sigma_px, double least) const {
  std::vector<SpotPeak> peaks = spot_peaks(images_, sigma_px, least);
  std::erase_if(peaks, [&](const SpotPeak& peak) { return !in_region(options_.region, pixel_of(peak)); });
  if (peaks.size() > kMostPeaks) {
    std::vector<float> best;
    for (const SpotPeak& peak : peaks) best.push_back(peak.significance);
    std::ranges::nth_element(best, best.begin() + kMostPeaks, std::ranges::greater());
    std::erase_if(peaks, [&](const SpotPeak& peak) { return peak.significance <= best[kMostPeaks]; });
  }
  return peaks;
}

void Finder::fit(SpotCandidate& candidate, const Spot& start, const SpotShape& shape, double sigma_px,
                 const std::vector<const Spot*>& others) const {
  candidate.fit.spot = start;
  candidate.fate = SpotFate::kGood;
  if (is_clipped(images_, start.pixel, sigma_px)) {
    candidate.fate = SpotFate::kClipped;
  } else if (is_saturated(images_, start.pixel, sigma_px)) {
    candidate.fate = SpotFate::kSaturated;
  } else {
    SpotWindow window = spot_window(images_, start.pixel, sigma_px, others);
    const bool even = take_even_surface(window, start.amplitude, images_.noise);
    if (!images_.pair() && !even) {
      candidate.fate = SpotFate::kOnEdge;
      return;
    }
    candidate.fit = fit_spot(window, start, shape, images_.noise);
    candidate.fate = fate_of(candidate.fit, shape, images_.pair(), candidate.peak, options_);
    candidate.fit.covariance_px2 *= std::max(1.0, candidate.fit.goodness);
    if (candidate.fate == SpotFate::kGood && window.contrast > 0.1) {
      std::ranges::fill(window.reflectance, 1.0);
      const SpotFit plain = fit_spot(window, candidate.fit.spot, shape, images_.noise);
      const Eigen::Vector2d moved = kDistrust * (plain.spot.pixel - candidate.fit.spot.pixel);
      candidate.fit.covariance_px2 += moved * moved.transpose();
    }
  }
}

// The median width of the most significant spots, from a filter that is matched better each time.
double Finder::spot_sigma() const {
  if (options_.spot_sigma_px > 0) return options_.spot_sigma_px;
  double sigma = kFirstSigma;
  for (int pass = 0; pass < 4; ++pass) {
    std::vector<SpotPeak> strongest = peaks(sigma, 1.2 * options_.least_significance);
    std::ranges::stable_sort(strongest, std::ranges::greater(), &SpotPeak::significance);
    std::vector<double> sigmas;
    // Print can outshine the spots: many peaks are tried.
    for (std::size_t i = 0; i < std::min(strongest.size(), 20 * kWidthSpots) && sigmas.size() < kWidthSpots; ++i) {
      SpotCandidate candidate{.fit = {}, .peak = pixel_of(strongest[i])};
      const SpotShape shape = round_shape(sigma, 1.0);
      fit(candidate, {candidate.peak, strongest[i].amplitude, shape.precision}, shape, sigma, {});
      if (candidate.fate == SpotFate::kGood) sigmas.push_back(mean_sigma(candidate.fit.spot.precision));
    }
    if (sigmas.size() < 3) break;
    std::ranges::nth_element(sigmas, sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2));
    const double before = sigma;
    sigma = std::clamp(sigmas[sigmas.size() / 2], kLeastSigma, kMostSigma);
    if (std::abs(sigma / before - 1) < 0.1) break;
  }
  return sigma;
}

// Spots whose light reaches into the window of candidate i.
std::vector<const Spot*> others_near(const std::vector<SpotCandidate>& candidates, std::size_t i, double reach_px) {
  std::vector<const Spot*> others;
  const auto add = [&](std::size_t k) {
    const SpotCandidate& other = candidates[k];
    const bool is_spot = other.fate == SpotFate::kGood || other.fate == SpotFate::kDoubled;
    if (is_spot && std::abs(other.peak.x() - candidates[i].peak.x()) < reach_px) others.push_back(&other.fit.spot);
  };
  for (std::size_t k = i; k-- > 0 && candidates[i].peak.y() - candidates[k].peak.y() < reach_px;) add(k);
  for (std::size_t k = i + 1; k < candidates.size() && candidates[k].peak.y() - candidates[i].peak.y() < reach_px;
       ++k) {
    add(k);
  }
  return others;
}

std::vector<SpotCandidate> Finder::candidates(double sigma_px) const {
  SpotShape shape = round_shape(sigma_px, 0.5);
  std::vector<SpotCandidate> found;
  // The filter knows less than the fit, which decides: a pair's difference has twice the noise that the fit will have
  // on even ground, and one image's filter is short.
  const double least = 0.65 * options_.least_significance;
  for (const SpotPeak& peak : peaks(sigma_px, least)) {
    found.push_back({.fit = {}, .peak = pixel_of(peak)});
    fit(found.back(), {found.back().peak, peak.amplitude, shape.precision}, shape, sigma_px, {});
  }
  // Again, with the neighbours' light taken away and the image's usual shape known.
  shape = usual_shape(found, shape);
  const double reach = 8 * sigma_px;
  const std::vector<SpotCandidate> alone = found;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool hopeless = alone[i].fate == SpotFate::kClipped || alone[i].fate == SpotFate::kSaturated;
    const std::vector<const Spot*> others = others_near(alone, i, reach);
    if (hopeless || (others.empty() && alone[i].fate == SpotFate::kOnEdge)) continue;
    Spot start = alone[i].fit.spot;
    if (alone[i].fate != SpotFate::kGood) start = {alone[i].peak, start.amplitude, shape.precision};
    fit(found[i], start, shape, sigma_px, others);
  }
  mark_doubles(found, sigma_px);
  return found;
}

double median_noise(const DotImages& images) {
  std::vector<float> greys;
  for (int y = 0; y < images.on.rows; y += 4) {
    for (int x = 0; x < images.on.cols; x += 4) greys.push_back(images.on.at<float>(y, x));
  }
  const auto middle = greys.begin() + static_cast<std::ptrdiff_t>(greys.size() / 2);
  std::ranges::nth_element(greys, middle);
  return std::sqrt(images.noise.variance(static_cast<double>(*middle)));
}

// The region as a mask; everything without one.
cv::Mat mask_of(const std::vector<Eigen::Vector2d>& region, cv::Size size) {
  if (region.empty()) return {size, CV_8U, cv::Scalar(1)};
  std::vector<cv::Point> corners;
  for (const Eigen::Vector2d& corner : region) corners.emplace_back(cvRound(corner.x()), cvRound(corner.y()));
  cv::Mat mask(size, CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(mask, corners, cv::Scalar(1));
  return mask;
}

// The noise of the whole image may not be that of the region: the difference of a pair shows by how much spots have to
// stand out more.
DotOptions heeding_noise(const DotImages& images, DotOptions options) {
  if (!images.pair()) return options;
  const double excess = noise_excess(images, kFirstSigma, mask_of(options.region, images.on.size()));
  options.least_significance *= std::max(1.0, excess);
  return options;
}

}  // namespace

FoundDots find_dots(const cv::Mat& on, const cv::Mat* off, const DotOptions& given) {
  const DotImages images = dot_images(on, off, given);
  const DotOptions options = heeding_noise(images, given);
  const Finder finder(images, options);
  const double sigma = finder.spot_sigma();
  FoundDots found;
  found.background_noise = median_noise(images);
  std::vector<double> sigmas;
  for (const SpotCandidate& candidate : finder.candidates(sigma)) {
    switch (candidate.fate) {
      case SpotFate::kSaturated:
        ++found.saturated;
        continue;
      case SpotFate::kClipped:
        ++found.clipped;
        continue;
      case SpotFate::kDoubled:
        ++found.doubled;
        continue;
      case SpotFate::kFaint:
        ++found.faint;
        continue;
      case SpotFate::kStreak:
        ++found.streaks;
        continue;
      case SpotFate::kOnEdge:
        ++found.on_edge;
        continue;
      case SpotFate::kGood:
        break;
    }
    const Spot& spot = candidate.fit.spot;
    sigmas.push_back(mean_sigma(spot.precision));
    Dot dot;
    dot.pixel = spot.pixel;
    const Eigen::Matrix2d& covariance = candidate.fit.covariance_px2;
    dot.covariance_px2 = 0.5 * (covariance + covariance.transpose());  // rounding
    dot.brightness = 2 * std::numbers::pi * spot.amplitude * sigmas.back() * sigmas.back();
    found.dots.push_back(dot);
  }
  if (!sigmas.empty()) {
    std::ranges::nth_element(sigmas, sigmas.begin() + static_cast<std::ptrdiff_t>(sigmas.size() / 2));
    found.spot_sigma_px = sigmas[sigmas.size() / 2];
  }
  return found;
}

}  // namespace raybundle
