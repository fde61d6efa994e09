// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "eye_safety_limits.hpp"

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr double kAperture_m = 7e-3;
constexpr double kPoint_mrad = 1.5, kLargest_mrad = 100.0;

// The largest size that counts, of an exposure of this length.
double largest_mrad(const SafetyEdition& edition, double seconds) {
  if (!edition.later_c5 || seconds > 0.25) return kLargest_mrad;
  return seconds < 625e-6 ? 5.0 : 200.0 * std::sqrt(seconds);
}

double c6_of(const LaserDrive& drive, const SafetyEdition& edition, double seconds) {
  return std::clamp(drive.source_mrad, kPoint_mrad, largest_mrad(edition, seconds)) / kPoint_mrad;
}

// T2, or the time base.
double exposure_of(const LaserDrive& drive, const SafetyEdition& edition) {
  if (!edition.exposure_by_size) return 100.0;
  const double beyond_point = std::clamp(drive.source_mrad, kPoint_mrad, kLargest_mrad) - kPoint_mrad;
  return 10.0 * std::pow(10.0, beyond_point / (kLargest_mrad - kPoint_mrad));
}

// How much less a pulse may have for being one of many.
double c5_of(const LaserDrive& drive, const SafetyEdition& edition, double pulses) {
  const double by_number = std::min(1.0, std::pow(pulses, -0.25));
  if (drive.pulse_s > 0.25) return 1.0;
  if (!edition.later_c5) return by_number;
  if (drive.pulse_s <= edition.shortest_s) return pulses <= 600.0 ? 1.0 : std::max(0.4, 5.0 * by_number);
  if (drive.source_mrad <= 5.0 || drive.source_mrad > kLargest_mrad) return 1.0;
  return std::max(by_number, drive.source_mrad <= largest_mrad(edition, drive.pulse_s) ? 0.4 : 0.2);
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
  require(drive.rate_Hz * edition.shortest_s <= 1.0,
          "pulses this close together count as groups, which these formulas leave out: lower the rate");
  SafetyLimit limit;
  limit.c4 = std::pow(10.0, 0.002 * (drive.wavelength_nm - 700.0));
  limit.c6 = c6_of(drive, edition, drive.pulse_s);
  limit.exposure_s = exposure_of(drive, edition);
  limit.pulses = std::max(1.0, drive.rate_Hz * limit.exposure_s);
  limit.c5 = c5_of(drive, edition, limit.pulses);
  const bool shortest = drive.pulse_s < edition.shortest_s;
  const double single_J = shortest ? edition.shortest_limit_J : 7e-4 * std::pow(drive.pulse_s, 0.75);
  limit.single_pulse_W = single_J * limit.c4 * limit.c6 / drive.pulse_s;
  limit.pulse_train_W = limit.c5 * limit.single_pulse_W;
  const bool point = edition.exposure_by_size && drive.source_mrad <= kPoint_mrad;
  const double plain_W = point ? 3.9e-4 : 7e-4 * std::pow(limit.exposure_s, -0.25);  // the tables round that of a point
  const double mean_W = plain_W * limit.c4 * c6_of(drive, edition, limit.exposure_s);
  limit.average_W = mean_W / (drive.pulse_s * drive.rate_Hz);
  return limit;
}

int beams_in_aperture(const std::vector<Line3>& beams, double distance_m) {
  const Eigen::Vector3d source = point_nearest_to(beams);
  std::vector<Eigen::Vector3d> places;  // on a sphere about the source
  for (const Line3& beam : beams) {
    const Eigen::Vector3d foot = beam.at((source - beam.point).dot(beam.direction));
    places.push_back((foot - source + distance_m * beam.direction).normalized() * distance_m);
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
