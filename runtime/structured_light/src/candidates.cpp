// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/candidates.hpp"

#include <cassert>
#include <cmath>

namespace raybundle {
namespace {

// Log-odds of a dot within the sensor's depths against one out of them: they are chosen to hold nine dots in ten.
constexpr double kWithinDepths = 2.2;

}  // namespace

BeamSet::BeamSet(const SensorTable& table_)
    : table(table_), beams(table.beams.size()), most_by_wavelength(table.beams.size()) {
  set_log_wavelength(0.0);
}

void BeamSet::set_log_wavelength(double log_wavelength_) {
  log_wavelength = log_wavelength_;
  const double nearest = 1.0 / table.range.explained_from_m();
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const BeamGeometry& beam = beams[i] = beam_geometry(table.beams[i], log_wavelength);
    // At an inverse distance i, on a ray r, along = r · direction / i - point · direction.
    const double offset = beam.wavelength[0] - beam.wavelength[1] * beam.point.dot(beam.direction);
    most_by_wavelength[i] = nearest * std::abs(offset) + std::abs(beam.wavelength[1]);
  }
}

Candidates::Candidates(int most_dots) {
  rays_.reserve(most_dots);
  candidates_.reserve(static_cast<std::size_t>(most_dots) * kMostOfDot);
  first_.reserve(most_dots + 1);
}

void Candidates::find(const BeamSet& set, std::span<const Dot> dots) {
  assert(dots.size() <= rays_.capacity());
  const SensorRange& range = set.table.range;
  const double unknown = kGateSigmas * std::sqrt(set.log_wavelength_variance);  // part of ln(wavelength)
  rays_.clear();
  candidates_.clear();
  first_.assign(1, 0);
  for (const Dot& dot : dots) {
    const bool in_image = set.table.rays.size.contains(dot.pixel);
    const RayTable::Ray ray = in_image ? set.table.rays.at(dot.pixel) : RayTable::Ray{};
    const std::size_t begin = candidates_.size();
    const double most_per_px = ray.per_px.norm();
    const auto beams = in_image ? set.table.candidates.at(dot.pixel) : std::span<const std::uint16_t>{};
    for (const int b : beams) {
      const BeamGeometry& beam = set.beams[b];
      const double off = beam.off_plane(ray.direction);
      const double most = range.tolerance_px * most_per_px + unknown * set.most_by_wavelength[b];
      if (!(std::abs(off) <= most)) continue;                                 // NaN: there is no ray
      const Eigen::Vector2d gradient = ray.per_px.transpose() * beam.normal;  // of off_plane by the pixel [1/px]
      const double per_px2 = gradient.squaredNorm();
      const BeamPoint point = beam_point(beam, ray.direction);
      const double by_wavelength = beam.off_plane_by_wavelength(point.along_m, point.inverse_distance);
      if (std::abs(off) > range.tolerance_px * std::sqrt(per_px2) + unknown * std::abs(by_wavelength)) continue;
      if (!(point.x.z() >= range.explained_from_m())) continue;
      const double variance = gradient.dot(dot.covariance_px2 * gradient) +
                              beam.off_plane_variance(point.along_m, point.inverse_distance) +
                              by_wavelength * by_wavelength * set.log_wavelength_variance;
      if (off * off > kGateSigmas * kGateSigmas * variance) continue;
      if (candidates_.size() - begin == kMostOfDot) {
        candidates_.resize(begin);
        break;
      }
      const double off_sigmas = off / std::sqrt(variance);
      const double density = range.tolerance_px * std::sqrt(per_px2 / variance * 2.0 / M_PI);  // at the curve
      const bool within = point.x.z() >= range.nearest_m && point.x.z() <= range.farthest_m;
      candidates_.push_back({static_cast<int>(rays_.size()), b, point.inverse_distance, off_sigmas,
                             std::log(density) - 0.5 * off_sigmas * off_sigmas - (within ? 0.0 : kWithinDepths),
                             within && set.table.beams[b].measured});
    }
    rays_.push_back(ray);
    first_.push_back(static_cast<int>(candidates_.size()));
  }
}

}  // namespace raybundle
