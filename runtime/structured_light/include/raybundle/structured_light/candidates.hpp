// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "raybundle/scene/laser.hpp"
#include "raybundle/structured_light/beam_geometry.hpp"

namespace raybundle {

/// A beam that may have made a dot: the dot lies on the beam's curve, not nearer than what is explained. Out of the
/// sensor's depths, or of a beam that is foreseen only, it explains the dot as others do, but is no measurement.
struct Candidate {
  int dot = 0;
  int beam = 0;                   ///< index into SensorTable::beams
  double inverse_distance = 0.0;  ///< from the camera's centre [1/m]
  double off_sigmas = 0.0;        ///< distance of the dot from the curve over its sigma, of dot, beam and wavelength
  double log_odds = 0.0;  ///< by distance and depth: a dot of the beam against one anywhere within the tolerance
  bool measures = true;
};

/// The beams as the runtime uses them, at the present wavelength.
struct BeamSet {
  explicit BeamSet(const SensorTable& table);

  /// Moves all beams to another wavelength; ln of it over that of the calibration.
  void set_log_wavelength(double log_wavelength);

  const SensorTable& table;
  std::vector<BeamGeometry> beams;
  std::vector<double> most_by_wavelength;  ///< of each: bound of off_plane_by_wavelength(), either sign
  double log_wavelength = 0.0;
  double log_wavelength_variance = 0.0;  ///< of that; its error is common to all beams. 0: taken as known
};

/// The candidates of all dots of an image, dot by dot. Its memory is taken once.
class Candidates {
 public:
  /// A dot with more candidates than this is one that no label can be found for.
  static constexpr int kMostOfDot = 48;

  explicit Candidates(int most_dots);

  /// Epipolar and depth test of every dot against the beams of its cell. A dot belongs to a curve within the table's
  /// tolerance and within `kGateSigmas`, where the wavelength's uncertainty widens both; one beside the image to none.
  ///
  /// @param dots  at most as many as said at the start
  void find(const BeamSet& beams, std::span<const Dot> dots);

  int dots() const { return static_cast<int>(rays_.size()); }
  std::span<const Candidate> all() const { return candidates_; }
  std::span<const Candidate> of_dot(int dot) const {
    return std::span(candidates_).subspan(first_[dot], first_[dot + 1] - first_[dot]);
  }
  int first_of_dot(int dot) const { return first_[dot]; }  ///< index into all()
  const RayTable::Ray& ray(int dot) const { return rays_[dot]; }

  static constexpr double kGateSigmas = 5.0;

 private:
  std::vector<RayTable::Ray> rays_;
  std::vector<Candidate> candidates_;
  std::vector<int> first_;
};

}  // namespace raybundle
