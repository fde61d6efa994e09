// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "board_scene.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "raybundle/geometry/error.hpp"
#include "view_geometry.hpp"

namespace raybundle {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMeshCells = 48;  // each way: chords of a bent board are nowhere near its edge on them
constexpr double kBorder =
    0.25;  // of the sheet's longer side: pixels that the edge of the sheet crosses have corners there
constexpr int kPacket = 8;

using Height = std::function<double(const Eigen::Vector2d&)>;

void fill_vertices(RTCGeometry geometry, const Eigen::Vector2d& low, const Eigen::Vector2d& step,
                   const Height& height) {
  constexpr int n = kMeshCells + 1;
  auto* vertex = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), n * n));
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Eigen::Vector2d place = low + step.cwiseProduct(Eigen::Vector2d(i, j));
      *vertex++ = static_cast<float>(place.x());
      *vertex++ = static_cast<float>(place.y());
      *vertex++ = static_cast<float>(height(place));
    }
  }
}

void fill_triangles(RTCGeometry geometry) {
  constexpr unsigned n = kMeshCells + 1;
  auto* index = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                               3 * sizeof(unsigned), 2 * kMeshCells * kMeshCells));
  for (unsigned j = 0; j + 1 < n; ++j) {
    for (unsigned i = 0; i + 1 < n; ++i) {
      const unsigned a = j * n + i, b = a + 1, c = a + n, d = c + 1;
      for (const unsigned corner : {a, b, d, a, d, c}) *index++ = corner;
    }
  }
}

std::shared_ptr<void> mesh_of(const BoardPrint::Box& sheet, const Height& height) {
  const std::shared_ptr<RTCDeviceTy> device(rtcNewDevice("threads=1"), rtcReleaseDevice);
  if (!device) throw Error(ErrorKind::kSolveFailed, "Embree cannot be started on this machine");
  const RTCScene scene = rtcNewScene(device.get());
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const double border = kBorder * (sheet.high - sheet.low).maxCoeff();
  const Eigen::Vector2d low = sheet.low.array() - border;
  const Eigen::Vector2d step = (sheet.high - sheet.low).array() + 2 * border;
  fill_vertices(geometry, low, step / kMeshCells, height);
  fill_triangles(geometry);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return {static_cast<void*>(scene), [device](void* mesh) { rtcReleaseScene(static_cast<RTCScene>(mesh)); }};
}

// Rays from one point, eight at a time; rays are pushed until the packet is full.
struct Packet {
  alignas(32) std::array<int, kPacket> valid{};
  alignas(32) RTCRayHit8 rays{};
  std::array<std::size_t, kPacket> index{};
  int count = 0;

  void push(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, std::size_t at) {
    RTCRay8& ray = rays.ray;
    ray.org_x[count] = static_cast<float>(origin.x());
    ray.org_y[count] = static_cast<float>(origin.y());
    ray.org_z[count] = static_cast<float>(origin.z());
    ray.dir_x[count] = static_cast<float>(direction.x());
    ray.dir_y[count] = static_cast<float>(direction.y());
    ray.dir_z[count] = static_cast<float>(direction.z());
    ray.tnear[count] = 0;
    ray.tfar[count] = std::numeric_limits<float>::infinity();
    ray.time[count] = 0;
    ray.mask[count] = ~0u;
    rays.hit.geomID[count] = RTC_INVALID_GEOMETRY_ID;
    valid[count] = -1;
    index[count++] = at;
  }

  void trace(void* mesh) {
    for (int i = count; i < kPacket; ++i) valid[i] = 0;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid.data(), static_cast<RTCScene>(mesh), &context, &rays);
  }

  bool hit(int i) const { return rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID; }
};

}  // namespace

BoardScene::BoardScene(const SimulatedBoard& board) : sheet_(board.print.sheet) {
  const BoardSurface surface(board.target);
  const auto at = [&](double x, double y) { return surface.height(x, y, board.shape); };
  c_ = at(0, 0);
  x_ = (at(1, 0) - at(-1, 0)) / 2;
  y_ = (at(0, 1) - at(0, -1)) / 2;
  xx_ = (at(1, 0) + at(-1, 0)) / 2 - c_;
  yy_ = (at(0, 1) + at(0, -1)) / 2 - c_;
  xy_ = at(1, 1) - c_ - x_ - y_ - xx_ - yy_;
  mesh_ = mesh_of(sheet_, [this](const Eigen::Vector2d& place) { return height(place); });
}

double BoardScene::height(const Eigen::Vector2d& place) const {
  const double x = place.x(), y = place.y();
  return c_ + x * (x_ + xx_ * x + xy_ * y) + y * (y_ + yy_ * y);
}

Eigen::Vector3d BoardScene::normal(const Eigen::Vector2d& place) const {
  const double x = place.x(), y = place.y();
  return Eigen::Vector3d(-(x_ + 2 * xx_ * x + xy_ * y), -(y_ + 2 * yy_ * y + xy_ * x), 1).normalized();
}

// z - height is quadratic along the ray; of its two zeros the one that stays where it is when the board is flattened.
std::optional<Eigen::Vector3d> BoardScene::crossing(const Eigen::Vector3d& origin,
                                                    const Eigen::Vector3d& direction) const {
  const double x = origin.x(), y = origin.y(), u = direction.x(), v = direction.y();
  const double a = -(xx_ * u * u + yy_ * v * v + xy_ * u * v);
  const double b = direction.z() - (x_ * u + y_ * v + 2 * xx_ * x * u + 2 * yy_ * y * v + xy_ * (x * v + y * u));
  const double c = origin.z() - height(origin.head<2>());
  const double root = b * b - 4 * a * c;
  if (!(root >= 0)) return std::nullopt;
  const double t = -2 * c / (b + std::copysign(std::sqrt(root), b));
  if (!(t > 0 && std::isfinite(t))) return std::nullopt;
  return origin + t * direction;
}

std::vector<Eigen::Vector2d> BoardScene::places(const Eigen::Vector3d& origin,
                                                const std::vector<Eigen::Vector3d>& directions) const {
  std::vector<Eigen::Vector2d> places(directions.size(), Eigen::Vector2d(kNaN, kNaN));
  Packet packet;
  const auto flush = [&] {
    packet.trace(mesh_.get());
    for (int i = 0; i < packet.count; ++i) {
      if (!packet.hit(i)) continue;
      const auto place = crossing(origin, directions[packet.index[i]]);
      if (place) places[packet.index[i]] = place->head<2>();
    }
    packet.count = 0;
  };
  for (std::size_t i = 0; i < directions.size(); ++i) {
    if (std::isnan(directions[i].x())) continue;
    packet.push(origin, directions[i], i);
    if (packet.count == kPacket) flush();
  }
  if (packet.count > 0) flush();
  return places;
}

bool BoardScene::near_sheet(const std::vector<Eigen::Vector3d>& places) const {
  if (places.empty()) return false;
  Eigen::Vector2d low = places[0].head<2>(), high = low;
  for (const Eigen::Vector3d& place : places) {
    low = low.cwiseMin(place.head<2>());
    high = high.cwiseMax(place.head<2>());
  }
  return (low.array() <= sheet_.high.array()).all() && (high.array() >= sheet_.low.array()).all();
}

std::optional<Eigen::Vector3d> BoardScene::sheet_crossing(const Eigen::Vector3d& origin,
                                                          const Eigen::Vector3d& direction) const {
  Packet packet;
  packet.push(origin, direction, 0);
  packet.trace(mesh_.get());
  if (!packet.hit(0)) return std::nullopt;
  const auto place = crossing(origin, direction);
  return place && contains(sheet_, place->head<2>()) ? place : std::nullopt;
}

}  // namespace raybundle
