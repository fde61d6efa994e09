// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/synthetic/emitter.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// Snell's law in vectors; nullopt: total reflection.
//
// normal   unit vector against the incoming direction
// ratio    index before over index behind
std::optional<Eigen::Vector3d> refracted(const Eigen::Vector3d& direction, const Eigen::Vector3d& normal,
                                         double ratio) {
  const double cosine = -direction.dot(normal);
  const double k = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
  if (!(k > 0)) return std::nullopt;
  return (ratio * direction + (ratio * cosine - std::sqrt(k)) * normal).normalized();
}

std::optional<Line3> through_plane(const Line3& ray, double z, double ratio) {
  const Eigen::Vector3d point = ray.at((z - ray.point.z()) / ray.direction.z());
  const auto direction = refracted(ray.direction, -Eigen::Vector3d::UnitZ(), ratio);
  return direction ? std::optional(Line3{point, *direction}) : std::nullopt;
}

// The half of a sphere that bulges towards the glass: behind its centre when the hollow faces the grating, before it
// when the hollow faces the scene.
std::optional<Line3> through_sphere(const Line3& ray, const Eigen::Vector3d& centre, double radius, bool behind_centre,
                                    double ratio) {
  const Eigen::Vector3d from_centre = ray.point - centre;
  const double along = from_centre.dot(ray.direction);
  const double discriminant = along * along - from_centre.squaredNorm() + radius * radius;
  if (!(discriminant > 0)) return std::nullopt;
  const Eigen::Vector3d point = ray.at(-along + (behind_centre ? 1.0 : -1.0) * std::sqrt(discriminant));
  if ((point.z() > centre.z()) != behind_centre) return std::nullopt;  // beyond the rim of the half sphere
  Eigen::Vector3d normal = (point - centre) / radius;
  if (normal.dot(ray.direction) > 0) normal = -normal;
  const auto direction = refracted(ray.direction, normal, ratio);
  return direction ? std::optional(Line3{point, *direction}) : std::nullopt;
}

std::optional<Line3> through_lens(const SpreadingLens& lens, const Line3& ray) {
  const double front = lens.distance_m, back = lens.distance_m + lens.thickness_m;
  const auto centre_at = [&](double z) { return Eigen::Vector3d(lens.offset_m.x(), lens.offset_m.y(), z); };
  if (lens.concave_inside) {
    const auto inside = through_sphere(ray, centre_at(front - lens.radius_m), lens.radius_m, true, 1.0 / lens.index);
    return inside ? through_plane(*inside, back, lens.index) : std::nullopt;
  }
  const auto inside = through_plane(ray, front, 1.0 / lens.index);
  return inside ? through_sphere(*inside, centre_at(back + lens.radius_m), lens.radius_m, false, lens.index)
                : std::nullopt;
}

// Angle off the axis behind the lens [rad]; nothing where the ray does not get through.
std::optional<double> spread_angle(const Emitter& emitter, double m, double n) {
  const auto ray = ray_of_order(emitter, m, n);
  if (!ray) return std::nullopt;
  return std::atan2(ray->direction.head<2>().norm(), ray->direction.z());
}

// The direction cosine of a single order whose ray leaves the lens at half the field.
double cosine_for(const Emitter& emitter, double half_field_rad, bool along_columns) {
  Emitter unit = emitter;
  unit.column_period_m = unit.row_period_m = emitter.wavelength_m;  // so that orders are direction cosines
  const auto angle = [&](double cosine) {
    return along_columns ? spread_angle(unit, cosine, 0) : spread_angle(unit, 0, cosine);
  };
  double low = 0.0, high = 0.0;
  for (double cosine = 0.002; cosine < 0.999 && high == 0.0; cosine += 0.002) {
    const auto spread = angle(cosine);
    if (!spread) break;
    (*spread < half_field_rad ? low : high) = cosine;
  }
  if (high == 0.0) {
    throw Error(ErrorKind::kBadInput,
                "the emitter cannot spread its beams to " + std::to_string(half_field_rad * 360.0 / M_PI) +
                    " degrees: beyond " + std::to_string(angle(low).value_or(0.0) * 360.0 / M_PI) +
                    " they miss the lens or are reflected in it; take a larger radius, a smaller field or another "
                    "distance");
  }
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    const auto spread = angle(middle);
    (spread && *spread < half_field_rad ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<Line3> ray_of_order(const Emitter& emitter, double m, double n) {
  const double cosine = std::cos(emitter.lattice_turn_rad), sine = std::sin(emitter.lattice_turn_rad);
  const double x = emitter.wavelength_m * m / emitter.column_period_m;
  const double y = emitter.wavelength_m * n / emitter.row_period_m;
  const Eigen::Vector2d cosines(cosine * x - sine * y, sine * x + cosine * y);
  if (!(cosines.squaredNorm() < 1.0)) return std::nullopt;
  const Line3 ray{Eigen::Vector3d::Zero(), {cosines.x(), cosines.y(), std::sqrt(1.0 - cosines.squaredNorm())}};
  return emitter.lens ? through_lens(*emitter.lens, ray) : ray;
}

std::vector<EmittedBeam> beams_of(const Emitter& emitter) {
  std::vector<EmittedBeam> beams;
  const auto add = [&](int row, int column, double m, double n, double power) {
    const auto ray = ray_of_order(emitter, m, n);
    if (!ray) {
      throw Error(ErrorKind::kBadInput, "beam (row " + std::to_string(row) + ", column " + std::to_string(column) +
                                            ") does not leave the emitter; take a smaller field");
    }
    beams.push_back({row, column, emitter.rig_from_emitter * *ray, power});
  };
  bool zero_is_in_grid = false;
  for (int row = 0; row < emitter.grid.rows; ++row) {
    for (int column = 0; column < emitter.grid.columns; ++column) {
      const double m = column - emitter.zero_order_column, n = row - emitter.zero_order_row;
      const bool zero = m == 0.0 && n == 0.0;
      zero_is_in_grid |= zero;
      const double power = emitter.beam_power_W * (zero ? emitter.zero_order_power : 1.0);
      const bool made = std::ranges::find(emitter.missing, std::pair(row, column)) == emitter.missing.end();
      if (made && power > 0) add(row, column, m, n, power);
    }
  }
  if (!zero_is_in_grid && emitter.zero_order_power > 0) {
    add(-1, -1, 0.0, 0.0, emitter.beam_power_W * emitter.zero_order_power);
  }
  return beams;
}

void set_grid(Emitter& emitter, const LaserGrid& grid) {
  if (std::min({grid.rows, grid.columns, emitter.grid.rows, emitter.grid.columns}) < 2) {
    throw Error(ErrorKind::kBadInput, "a grid of beams that fills the field of another needs at least 2x2 beams");
  }
  emitter.column_period_m *= (grid.columns - 1.0) / (emitter.grid.columns - 1.0);
  emitter.row_period_m *= (grid.rows - 1.0) / (emitter.grid.rows - 1.0);
  emitter.grid = grid;
  emitter.zero_order_column = 0.5 * (grid.columns - 1);
  emitter.zero_order_row = 0.5 * (grid.rows - 1);
  if (grid.columns % 2 == 0 || grid.rows % 2 == 0) emitter.zero_order_power = 0.0;
  emitter.missing.clear();
}

void set_periods_from_field(Emitter& emitter, const Eigen::Vector2d& field_rad) {
  const double columns = 0.5 * (emitter.grid.columns - 1), rows = 0.5 * (emitter.grid.rows - 1);
  if (!(columns > 0 && rows > 0)) {
    throw Error(ErrorKind::kBadInput, "an emitter with a single row or column has no field; give its period");
  }
  emitter.column_period_m = emitter.wavelength_m * columns / cosine_for(emitter, 0.5 * field_rad.x(), true);
  emitter.row_period_m = emitter.wavelength_m * rows / cosine_for(emitter, 0.5 * field_rad.y(), false);
}

Emitter warmer(const Emitter& emitter, double kelvin) {
  Emitter warm = emitter;
  warm.wavelength_m += kelvin * emitter.wavelength_drift_m_K;
  return warm;
}

}  // namespace raybundle
