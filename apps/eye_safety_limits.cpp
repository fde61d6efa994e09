// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "eye_safety_limits.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr double kAperture_m = 7e-3, kDistance_m = 0.1;
constexpr double kPoint_mrad = 1.5, kLargest_mrad = 100.0;

double single_pulse_J(double seconds, const SafetyEdition& edition, double c4, double c6) {
  return (seconds < edition.shortest_s ? edition.shortest_limit_J : 7e-4 * std::pow(seconds, 0.75)) * c4 * c6;
}

// Pulses of a train, of sources that are larger than a point; edition 2014: 0.4 and 0.2 at the least.
double c5_of(const LaserDrive& drive, const SafetyEdition& edition, double pulses) {
  const double c5 = std::min(1.0, std::pow(pulses, -0.25));
  if (edition.small_sources_count) return c5;
  if (drive.source_mrad <= 5.0) return 1.0;
  return std::max(c5, drive.source_mrad <= kLargest_mrad ? 0.4 : 0.2);
}

Eigen::Vector3d common_point(const std::vector<Line3>& beams) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Line3& beam : beams) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - beam.direction * beam.direction.transpose();
    normal += across;
    right += across * beam.point;
  }
  return normal.ldlt().solve(right);
}

}  // namespace

double SafetyLimit::least_W() const { return std::min({single_pulse_W, average_W, pulse_train_W}); }

SafetyLimit safety_limit(const LaserDrive& drive, const SafetyEdition& edition) {
  const auto require = [](bool holds, const char* message) {
    if (!holds) throw Error(ErrorKind::kBadInput, message);
  };
  require(drive.wavelength_nm >= 700.0 && drive.wavelength_nm <= 1050.0,
          "the wavelength must be from 700 to 1050 nm: other formulas hold elsewhere");
  require(drive.pulse_s >= 1e-9 && drive.pulse_s <= 10.0, "a pulse must last from 1 ns to 10 s");
  require(drive.rate_Hz > 0.0 && drive.pulse_s * drive.rate_Hz <= 1.0, "pulses must not overlap: lower the rate");
  require(drive.source_mrad > 0.0, "the source's size must be positive");
  SafetyLimit limit;
  limit.c4 = std::pow(10.0, 0.002 * (drive.wavelength_nm - 700.0));
  limit.c6 = std::clamp(drive.source_mrad, kPoint_mrad, kLargest_mrad) / kPoint_mrad;
  limit.pulses = std::max(1.0, drive.rate_Hz * edition.longest_pulses_s);
  limit.c5 = c5_of(drive, edition, limit.pulses);
  const double single_J = single_pulse_J(drive.pulse_s, edition, limit.c4, limit.c6);
  limit.single_pulse_W = single_J / drive.pulse_s;
  limit.pulse_train_W = limit.c5 * limit.single_pulse_W;
  const double exposure_s = edition.longest_pulses_s;
  const double mean_W = 7e-4 * std::pow(exposure_s, 0.75) * limit.c4 * limit.c6 / exposure_s;
  limit.average_W = mean_W / (drive.pulse_s * drive.rate_Hz);
  return limit;
}

int beams_in_aperture(const std::vector<Line3>& beams) {
  const Eigen::Vector3d source = common_point(beams);
  std::vector<Eigen::Vector3d> places;  // on a sphere about the source
  for (const Line3& beam : beams) {
    const Eigen::Vector3d foot = beam.at((source - beam.point).dot(beam.direction));
    places.push_back((foot - source + kDistance_m * beam.direction).normalized() * kDistance_m);
  }
  // Of all discs with the most points, one has two of them on its rim or one in its middle.
  constexpr double kRadius_m = 0.5 * kAperture_m;
  const auto count = [&](const Eigen::Vector3d& centre) {
    return static_cast<int>(std::ranges::count_if(
        places, [&](const Eigen::Vector3d& place) { return (place - centre).norm() <= kRadius_m * (1.0 + 1e-9); }));
  };
  int most = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    most = std::max(most, count(places[i]));
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Eigen::Vector3d apart = places[k] - places[i];
      const double half = 0.5 * apart.norm();
      if (i == k || half <= 0.0 || half > kRadius_m) continue;
      const Eigen::Vector3d middle = 0.5 * (places[i] + places[k]);
      const Eigen::Vector3d aside = apart.cross(middle).normalized() * std::sqrt(kRadius_m * kRadius_m - half * half);
      most = std::max(most, count(middle + aside));
    }
  }
  return most;
}

}  // namespace raybundle::apps
