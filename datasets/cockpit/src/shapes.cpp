// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "shapes.hpp"

#include <cmath>

namespace raybundle {
namespace {

constexpr int kAround = 16;  // segments around a limb
constexpr int kCap = 4;      // rings of a half ball

double signed_power(double base, double exponent) { return std::copysign(std::pow(std::abs(base), exponent), base); }

}  // namespace

CabinMesh grid_mesh(int columns, int rows, const std::function<Eigen::Vector3d(double, double)>& at) {
  CabinMesh mesh;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      mesh.vertices.push_back(at(static_cast<double>(i) / columns, static_cast<double>(j) / rows).cast<float>());
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      mesh.triangles.emplace_back(a, b, d);
      mesh.triangles.emplace_back(a, d, c);
    }
  }
  mesh.places = mesh.vertices;
  return mesh;
}

CabinMesh round_cone(double length_m, double radius_m, double end_radius_m) {
  std::vector<Eigen::Vector2d> profile;  // radius, z
  for (int i = 0; i <= kCap; ++i) {
    const double angle = 0.5 * M_PI * i / kCap;
    profile.emplace_back(radius_m * std::sin(angle), -radius_m * std::cos(angle));
  }
  for (int i = 0; i <= kCap; ++i) {
    const double angle = 0.5 * M_PI * i / kCap;
    profile.emplace_back(end_radius_m * std::cos(angle), length_m + end_radius_m * std::sin(angle));
  }
  const int rows = static_cast<int>(profile.size()) - 1;
  return grid_mesh(kAround, rows, [&](double u, double v) {
    const Eigen::Vector2d& ring = profile[static_cast<std::size_t>(std::lround(v * rows))];
    const double angle = 2 * M_PI * u;
    return Eigen::Vector3d(ring.x() * std::cos(angle), ring.x() * std::sin(angle), ring.y());
  });
}

CabinMesh rounded_box(const Eigen::Vector3d& semi_axes_m, double roundness, int longitudes) {
  const int latitudes = longitudes / 2;
  const auto rounded = [roundness](double angle) {
    return Eigen::Vector2d(signed_power(std::cos(angle), roundness), signed_power(std::sin(angle), roundness));
  };
  std::vector<Eigen::Vector2d> around, upwards;
  for (int i = 0; i <= longitudes; ++i) around.push_back(rounded(2 * M_PI * i / longitudes));
  for (int i = 0; i <= latitudes; ++i) upwards.push_back(rounded(M_PI * i / latitudes - 0.5 * M_PI));
  return grid_mesh(longitudes, latitudes, [&](double u, double v) -> Eigen::Vector3d {
    const Eigen::Vector2d& at = around[static_cast<std::size_t>(std::lround(u * longitudes))];
    const Eigen::Vector2d& ring = upwards[static_cast<std::size_t>(std::lround(v * latitudes))];
    return semi_axes_m.cwiseProduct(Eigen::Vector3d(ring.x() * at.x(), ring.x() * at.y(), ring.y()));
  });
}

CabinMesh swept(const Polyline& line_xz, double y_from, double y_to) {
  const int rows = static_cast<int>(line_xz.size()) - 1;
  return grid_mesh(8, rows, [&](double u, double v) {
    const Eigen::Vector2d& corner = line_xz[static_cast<std::size_t>(std::lround(v * rows))];
    return Eigen::Vector3d(corner.x(), y_from + (y_to - y_from) * u, corner.y());
  });
}

CabinMesh placed(CabinMesh mesh, const Rigid3& vehicle_from_body, CabinPart part, const CabinMaterial& material) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex = (vehicle_from_body * vertex.cast<double>()).cast<float>();
  mesh.part = part;
  mesh.material = material;
  return mesh;
}

CabinMesh limb(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_m, double end_radius_m,
               CabinPart part, const CabinMaterial& material) {
  const Eigen::Vector3d along = to - from;
  const Rigid3 pose{Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along), from};
  return placed(round_cone(along.norm(), radius_m, end_radius_m), pose, part, material);
}

}  // namespace raybundle
