// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "raybundle/device/image_view.hpp"
#include "raybundle/device/state.hpp"
#include "raybundle/structured_light/dot_finder.hpp"
#include "raybundle/structured_light/health.hpp"
#include "raybundle/structured_light/labels.hpp"
#include "raybundle/structured_light/laser_points.hpp"

namespace raybundle {

struct StructuredLightOptions {
  Labeller labeller = kLabellers.front();
  DotFinderOptions dots;
  HealthOptions health;
  bool follow_wavelength = true;  ///< moves the beams to the wavelength that the dots tell; else it is taken as known
  double most_slant = 6.0;        ///< of the mesh: longer sides over those of a surface that faces the camera
  double least_labelled = 0.5;    ///< share of the dots below which the state is kDegraded
  double least_beams = 0.25;      ///< share of the table's beams with a point below which it is kDegraded, too
};

/// What one image says. The spans are of the sensor and valid until its next image.
struct LaserFrame {
  State state = State::kInvalid;
  std::span<const Dot> dots;  ///< with their beam (LaserGrid::index), or kUnlabelled
  std::span<const LaserPoint> points;
  std::span<const Triangle> mesh;  ///< of points
  HealthReport health;
};

/// From an image of laser dots to points in space: find the dots, label them, meet camera rays and beams, watch the
/// calibration. All memory is taken at the start; process() neither allocates nor throws, its loops are bounded, and
/// the same images give the same bits.
class StructuredLight {
 public:
  /// @param table  kept by the caller
  explicit StructuredLight(const SensorTable& table, const StructuredLightOptions& options = {});
  StructuredLight(const StructuredLight&) = delete;
  StructuredLight& operator=(const StructuredLight&) = delete;

  /// An image of another size than the table's gives a frame without dots, kInvalid.
  ///
  /// @param on   image with the laser on
  /// @param off  the same scene with the laser off, or a view without pixels
  const LaserFrame& process(const GreyView& on, const GreyView& off = {});

  /// The same from dots that were found elsewhere; at most most_dots() of them.
  const LaserFrame& process(std::span<const Dot> dots);

  int most_dots() const { return most_dots_; }
  const SensorTable& table() const { return beams_.table; }

 private:
  /// Leaves the beams at the wavelength by which the labels are likeliest, or, when too few dots have one, at the
  /// calibration's with the uncertainty of before anything is seen. Whether it was found.
  bool find_wavelength();
  void choose_labels();
  void label_dots();
  void judge();

  StructuredLightOptions options_;
  int most_dots_;
  BeamSet beams_;
  BeamLattice lattice_;
  DotFinder finder_;
  Candidates candidates_;
  LabelWork work_;
  Health health_;
  bool drifts_;  ///< whether it is known of any beam how the wavelength moves it
  std::vector<Dot> dots_;
  std::vector<LaserPoint> points_;
  std::vector<int> point_of_beam_;
  std::vector<Health::Sample> samples_;
  std::vector<Triangle> mesh_;
  LaserFrame frame_;
};

}  // namespace raybundle
