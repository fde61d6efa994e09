// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "raybundle/cockpit/cabin_scene.hpp"
#include "raybundle/cockpit/sensor.hpp"
#include "raybundle/occupancy/scan.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "raybundle/occupancy/vehicle.hpp"

namespace raybundle::apps {

enum class SensorKind : std::uint8_t { kStructuredLight, kStereo };

/// A simulated cabin as a sensor measured it, and the truth about it.
struct MeasuredScene {
  VehicleLayout layout;
  CockpitTruth truth;
  Eigen::Vector3d viewpoint_in_vehicle = Eigen::Vector3d::Zero();  ///< [m]
  std::vector<ScenePoint> points;
  std::vector<CabinPart> parts;              ///< truth, aligned with points
  std::vector<Eigen::Vector3d> true_points;  ///< [m] in the vehicle frame, of dots, aligned with points; else none
  std::optional<SeatPose> seat;              ///< as it was fitted; none: nobody knows how it is set
  int rays = 0;
  State state = State::kOk;  ///< of the sensor

  Scan scan() const { return {viewpoint_in_vehicle, points, rays, state}; }
};

/// Which scene, by which sensor. The same request gives the same bits.
struct SceneRequest {
  SensorKind kind = SensorKind::kStructuredLight;
  CockpitRequest cockpit;
  LaserGrid grid{11, 11};
  ImageSize stereo_size{128, 128};
  int most_points = 0;  ///< of a stereo frame: every so-and-so-many-th pixel is taken; 0: all are
};

/// The sensor that a request names.
CabinSensor sensor_of(const SceneRequest& request);

/// What a laser measures, without images: dots with the noise of their light and right labels.
MeasuredScene measured_scene(const SceneRequest& request);

/// The same scene at one time after the other: what depends on the sensor alone is computed once.
class SceneSource {
 public:
  /// @param request  of a laser; its time does not matter
  explicit SceneSource(const SceneRequest& request);
  MeasuredScene at(double time_s) const;

  /// A cabin that is there already, as this sensor sees it: another sensor looks into the same cabin.
  MeasuredScene measured(const CabinScene& scene, double time_s) const;

 private:
  SceneRequest request_;
  CabinSensor sensor_;
};

/// What whoever installs the sensor knows of the simulated car.
VehicleLayout vehicle_layout(const CabinLayout& layout);

/// The true seat as a fit would give it without error.
SeatPose seat_pose(const SeatSetting& seat);

}  // namespace raybundle::apps
