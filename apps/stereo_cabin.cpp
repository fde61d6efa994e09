// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "stereo_cabin.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "raybundle/occupancy/seat_boxes.hpp"
#include "thinning.hpp"
#include "vehicle_file.hpp"

namespace raybundle::apps {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = M_PI / 180.0;

Json list(const Eigen::Vector3d& x) { return {x.x(), x.y(), x.z()}; }

// The twelve edges of a box, each from corner to corner.
std::vector<Eigen::Vector3d> edges_of(const Box& box) {
  const double c = std::cos(box.pitch_rad), s = std::sin(box.pitch_rad);
  const auto corner = [&](int i) -> Eigen::Vector3d {
    const Eigen::Vector3d x((i & 1 ? box.high : box.low).x(), (i & 2 ? box.high : box.low).y(),
                            (i & 4 ? box.high : box.low).z());
    return box.origin + Eigen::Vector3d(c * x.x() - s * x.z(), x.y(), s * x.x() + c * x.z());
  };
  std::vector<Eigen::Vector3d> edges;
  for (int i = 0; i < 8; ++i) {
    for (const int bit : {1, 2, 4}) {
      if ((i & bit) == 0) edges.insert(edges.end(), {corner(i), corner(i | bit)});
    }
  }
  return edges;
}

// Three circles about the axes of the vehicle; the head's own turn hardly shows.
std::vector<Eigen::Vector3d> circles_of(const Head& head) {
  constexpr int kSteps = 24;
  std::vector<Eigen::Vector3d> lines;
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < kSteps; ++i) {
      for (const int end : {i, i + 1}) {
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        place[(axis + 1) % 3] = std::cos(2 * M_PI * end / kSteps);
        place[(axis + 2) % 3] = std::sin(2 * M_PI * end / kSteps);
        lines.emplace_back(head.centre + place.cwiseProduct(head.semi_axes_m));
      }
    }
  }
  return lines;
}

}  // namespace

StereoCabin read_stereo_cabin(const std::string& path) {
  VehicleFile file(path);
  TomlReader section = file.section("stereo");
  StereoCabin cabin{file.layout(), pose_from(section)};
  section.refuse_unknown_keys();
  return cabin;
}

CabinWatch::CabinWatch(const StereoCabin& cabin, const Rectification& pair)
    : cabin_(cabin), vehicle_from_rectified_(cabin.vehicle_from_rig * pair.rig_from_rectified) {}

Scan CabinWatch::scan_of(const StereoFrame& frame) {
  points_.clear();
  const int step = thinning_step(frame.disparity.matched, kMostCabinPoints);
  const int columns = frame.points.width / step, rows = frame.points.height / step;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const StereoPoint& point = frame.points.at(column * step, row * step);
      if (point.sigma_m == 0.0F) continue;
      points_.push_back({row * columns + column,
                         vehicle_from_rectified_ * Eigen::Vector3d(point.x_m, point.y_m, point.z_m), point.sigma_m});
    }
  }
  return {vehicle_from_rectified_.translation, points_, rows * columns, frame.state};
}

double CabinWatch::chin_m() const {
  constexpr double kChin_m = 0.50, kLeast_m = 0.20;
  if (!head_.found) return kChin_m;
  const SeatPose seat = watch_.pose();
  const Eigen::Vector2d from_bight = Eigen::Vector2d(head_.centre.x(), head_.centre.z()) - seat.bight;
  return std::max(kLeast_m, from_bight.dot(seat.back_up()) - head_.semi_axes_m.z());
}

Json CabinWatch::take(const StereoFrame& frame) {
  const Scan scan = scan_of(frame);
  watch_.add(fit_seat(cabin_.layout, scan));
  head_ = find_head(cabin_.layout, watch_.pose(), scan);
  Json json{{"seat", nullptr}, {"head", nullptr}};
  if (watch_.frames() > 0) {
    const SeatFit seat = watch_.seat();
    json["seat"] = {{"bight_m", {seat.pose.bight.x(), seat.pose.bight.y()}},
                    {"bight_sigma_m", {seat.bight_sigma_m.x(), seat.bight_sigma_m.y()}},
                    {"recline_deg", seat.pose.recline_rad / kDegree},
                    {"recline_sigma_deg", seat.recline_sigma_rad / kDegree},
                    {"cushion_pitch_deg", seat.pose.cushion_pitch_rad / kDegree},
                    {"frames", watch_.frames()},
                    {"frames_since_seen", watch_.frames_since_seen()}};
  }
  if (head_.found) {
    json["head"] = {{"front_m", list(head_.front)},
                    {"front_sigma_m", list(head_.front_covariance_m2.diagonal().cwiseSqrt())},
                    {"centre_m", list(head_.centre)},
                    {"sigma_m", list(head_.covariance_m2.diagonal().cwiseSqrt())},
                    {"semi_axes_m", list(head_.semi_axes_m)},
                    {"to_dashboard_m", cabin_.layout.dashboard_x_m - head_.centre.x()},
                    {"points", head_.points}};
  }
  const auto boxes = seat_boxes(watch_.pose(), chin_m());
  for (int i = 0; i < kSeatPlaces; ++i) {
    const BoxCount count = count_rays(boxes[static_cast<std::size_t>(i)], scan);
    json["boxes"][std::string(kSeatPlaceNames[static_cast<std::size_t>(i)])] = {
        {"hits", count.hits}, {"passed", count.passed}, {"blocked", count.blocked}};
  }
  return json;
}

nlohmann::json CabinWatch::on_page() const { return {{"drawn", drawn()}, {"turn", turn()}, {"cabin", words()}}; }

// Rows of the rotation from the rectified frame to one with the car's front on the right, its floor below, and its
// left side away.
nlohmann::json CabinWatch::turn() const {
  const Eigen::Matrix3d vehicle = vehicle_from_rectified_.rotation.toRotationMatrix();
  nlohmann::json rows = nlohmann::json::array();
  for (const Eigen::RowVector3d& row :
       {Eigen::RowVector3d(vehicle.row(0)), Eigen::RowVector3d(-vehicle.row(2)), Eigen::RowVector3d(vehicle.row(1))}) {
    rows.insert(rows.end(), {row.x(), row.y(), row.z()});
  }
  return rows;
}

nlohmann::json CabinWatch::drawn() const {
  const Rigid3 rectified_from_vehicle = vehicle_from_rectified_.inverse();
  nlohmann::json all = nlohmann::json::array();
  const auto draw = [&](const char* colour, const std::vector<Eigen::Vector3d>& lines) {
    nlohmann::json places = nlohmann::json::array();
    for (const Eigen::Vector3d& end : lines) {
      const Eigen::Vector3d x = rectified_from_vehicle * end;
      for (const double value : {x.x(), x.y(), x.z()}) places.push_back(std::round(1e3 * value) / 1e3);
    }
    all.push_back({{"colour", colour}, {"lines", places}});
  };
  const VehicleLayout& car = cabin_.layout;
  const double half = car.zone_half_width_m, top = car.dashboard_top_m + 0.15, near = car.dashboard_x_m;
  const auto zone = [&](double from, double to) {
    return edges_of({.low = {near - to, -half, car.zone_floor_m}, .high = {near - from, half, top}});
  };
  draw("#e22", zone(0.0, car.critical_m));
  draw("#f90", zone(car.critical_m, car.out_of_position_m));
  for (const Eigen::AlignedBox3d& fixture : car.fixtures) {
    if (!fixture.isEmpty()) draw("#777", edges_of({.low = fixture.min(), .high = fixture.max()}));
  }
  const char* boxes = watch_.frames() > 0 ? "#6cf" : "#999";  // of the seat as it was fitted, or amid its travel
  for (const Box& box : seat_boxes(watch_.pose(), chin_m())) draw(boxes, edges_of(box));
  if (head_.found) draw("#fff", circles_of(head_));
  return all;
}

std::string CabinWatch::words() const {
  const std::string seat = watch_.frames() == 0             ? "seat not seen"
                           : watch_.frames_since_seen() > 0 ? "seat hidden"
                                                            : "seat seen";
  if (!head_.found) return seat + ", no head";
  return fmt::format("{}, head {:.3f} ± {:.3f} m from the dashboard", seat,
                     cabin_.layout.dashboard_x_m - head_.centre.x(), std::sqrt(head_.covariance_m2(0, 0)));
}

}  // namespace raybundle::apps
