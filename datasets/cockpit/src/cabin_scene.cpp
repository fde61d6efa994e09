// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cabin_scene.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pattern.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr int kPacket = 8;
constexpr double kOffSurface_m = 1e-3;

// All triangles as one geometry: a cabin has a hundred meshes, and each geometry costs time.
struct Traced {
  std::shared_ptr<RTCDeviceTy> device;
  std::shared_ptr<RTCSceneTy> scene;
  std::vector<int> mesh_of;                // for each triangle
  std::vector<Eigen::Vector3i> triangles;  // into normals and places
  std::vector<Eigen::Vector3f> normals, places;
};

RTCDevice new_device() {
  const RTCDevice device = rtcNewDevice("threads=1");
  if (device == nullptr) throw Error(ErrorKind::kSolveFailed, "Embree cannot be started on this machine");
  return device;
}

// Sums of the areas of a vertex's triangles. Seams and poles have several vertices at one place: normals there are
// those of one side, which nobody sees.
void add_normals(const CabinMesh& mesh, std::vector<Eigen::Vector3f>& normals) {
  const std::size_t first = normals.size();
  normals.resize(first + mesh.vertices.size(), Eigen::Vector3f::Zero());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3f& a = mesh.vertices[t[0]];
    const Eigen::Vector3f area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    for (int k = 0; k < 3; ++k) normals[first + t[k]] += area;
  }
}

std::shared_ptr<Traced> traced_from(const std::vector<CabinMesh>& meshes) {
  auto traced = std::make_shared<Traced>();
  std::vector<Eigen::Vector3f> vertices;
  for (int m = 0; m < static_cast<int>(meshes.size()); ++m) {
    const CabinMesh& mesh = meshes[m];
    const Eigen::Vector3i first = Eigen::Vector3i::Constant(static_cast<int>(vertices.size()));
    vertices.insert(vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    traced->places.insert(traced->places.end(), mesh.places.begin(), mesh.places.end());
    add_normals(mesh, traced->normals);
    for (const Eigen::Vector3i& t : mesh.triangles) {
      traced->triangles.push_back(first + t);
      traced->mesh_of.push_back(m);
    }
  }
  static const std::shared_ptr<RTCDeviceTy> device(new_device(), rtcReleaseDevice);
  traced->device = device;
  traced->scene.reset(rtcNewScene(device.get()), rtcReleaseScene);
  rtcSetSceneBuildQuality(traced->scene.get(), RTC_BUILD_QUALITY_LOW);  // few rays are sent into a scene
  const RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
  void* at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Eigen::Vector3f),
                                     vertices.size());
  std::copy(vertices.begin(), vertices.end(), static_cast<Eigen::Vector3f*>(at));
  at = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Eigen::Vector3i),
                               traced->triangles.size());
  std::copy(traced->triangles.begin(), traced->triangles.end(), static_cast<Eigen::Vector3i*>(at));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(traced->scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(traced->scene.get());
  return traced;
}

const Traced& traced_in(const std::shared_ptr<void>& pointer) { return *static_cast<const Traced*>(pointer.get()); }

template <typename Values>
Eigen::Vector3f mixed(const Values& values, const Eigen::Vector3i& t, float u, float v) {
  return (1 - u - v) * values[t[0]] + u * values[t[1]] + v * values[t[2]];
}

CabinHit hit_from(const Traced& traced, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, float distance,
                  unsigned triangle, float u, float v, const Eigen::Vector3f& flat_normal) {
  CabinHit hit;
  hit.distance_m = distance;
  hit.x_in_vehicle = origin + hit.distance_m * direction;
  hit.mesh = traced.mesh_of[triangle];
  hit.place = mixed(traced.places, traced.triangles[triangle], u, v);
  const Eigen::Vector3d flat = flat_normal.cast<double>().normalized();
  const Eigen::Vector3d toward = flat.dot(direction) > 0 ? Eigen::Vector3d(-flat) : flat;
  Eigen::Vector3d smooth = mixed(traced.normals, traced.triangles[triangle], u, v).cast<double>();
  if (smooth.dot(toward) < 0) smooth = -smooth;
  const double length = smooth.norm();
  // On sharp edges the smooth normal may point away from the ray; the flat one never does.
  const bool usable = length > 0 && smooth.dot(direction) < 0;
  hit.normal = usable ? Eigen::Vector3d(smooth / length) : toward;
  return hit;
}

struct Packet {
  alignas(32) std::array<int, kPacket> valid{};
  alignas(32) RTCRayHit8 rays{};
  std::array<std::size_t, kPacket> index{};
  int count = 0;

  void push(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, std::size_t at) {
    RTCRay8& ray = rays.ray;
    ray.org_x[count] = origin.x();
    ray.org_y[count] = origin.y();
    ray.org_z[count] = origin.z();
    ray.dir_x[count] = direction.x();
    ray.dir_y[count] = direction.y();
    ray.dir_z[count] = direction.z();
    ray.tnear[count] = 0;
    ray.tfar[count] = std::numeric_limits<float>::infinity();
    ray.time[count] = 0;
    ray.mask[count] = ~0u;
    rays.hit.geomID[count] = RTC_INVALID_GEOMETRY_ID;
    valid[count] = -1;
    index[count++] = at;
  }

  void trace(RTCScene scene) {
    for (int i = count; i < kPacket; ++i) valid[i] = 0;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid.data(), scene, &context, &rays);
  }

  void trace_shadows(RTCScene scene) {
    for (int i = count; i < kPacket; ++i) valid[i] = 0;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded8(valid.data(), scene, &context, &rays.ray);
  }
};

}  // namespace

CabinScene::CabinScene(Cockpit cockpit) : cockpit_(std::make_shared<const Cockpit>(std::move(cockpit))) {
  traced_ = traced_from(cockpit_->meshes);
}

std::optional<CabinHit> CabinScene::first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  CabinHit hit;
  first_hits(origin, {&direction, 1}, {&hit, 1});
  return hit.mesh < 0 ? std::nullopt : std::optional(hit);
}

void CabinScene::first_hits(const Eigen::Vector3d& origin, std::span<const Eigen::Vector3d> directions,
                            std::span<CabinHit> hits) const {
  const Traced& traced = traced_in(traced_);
  const Eigen::Vector3f start = origin.cast<float>();
  Packet packet;
  const auto flush = [&] {
    packet.trace(traced.scene.get());
    for (int i = 0; i < packet.count; ++i) {
      const RTCHit8& hit = packet.rays.hit;
      if (hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const std::size_t at = packet.index[i];
      hits[at] = hit_from(traced, origin, directions[at], packet.rays.ray.tfar[i], hit.primID[i], hit.u[i], hit.v[i],
                          {hit.Ng_x[i], hit.Ng_y[i], hit.Ng_z[i]});
    }
    packet.count = 0;
  };
  for (std::size_t i = 0; i < directions.size(); ++i) {
    hits[i].mesh = -1;
    if (std::isnan(directions[i].x())) continue;
    packet.push(start, directions[i].cast<float>(), i);
    if (packet.count == kPacket) flush();
  }
  if (packet.count > 0) flush();
}

bool CabinScene::blocked(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const Eigen::Vector3d way = to - from;
  const double length = way.norm();
  if (length <= 2 * kOffSurface_m) return false;
  const Eigen::Vector3f origin = from.cast<float>(), direction = (way / length).cast<float>();
  RTCRay ray{};
  ray.org_x = origin.x();
  ray.org_y = origin.y();
  ray.org_z = origin.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tnear = static_cast<float>(kOffSurface_m);
  ray.tfar = static_cast<float>(length - kOffSurface_m);
  ray.mask = ~0u;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(traced_in(traced_).scene.get(), &context, &ray);
  return ray.tfar < 0;
}

void CabinScene::blocked(std::span<const CabinHit> from, const Eigen::Vector3d& to,
                         std::span<std::uint8_t> dark) const {
  const RTCScene scene = traced_in(traced_).scene.get();
  Packet packet;
  const auto flush = [&] {
    packet.trace_shadows(scene);
    for (int i = 0; i < packet.count; ++i) dark[packet.index[i]] = packet.rays.ray.tfar[i] < 0;
    packet.count = 0;
  };
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from[i].mesh < 0) continue;
    const Eigen::Vector3d way = to - from[i].x_in_vehicle;
    const double length = way.norm();
    packet.push(from[i].x_in_vehicle.cast<float>(), (way / length).cast<float>(), i);
    packet.rays.ray.tnear[packet.count - 1] = static_cast<float>(kOffSurface_m);
    packet.rays.ray.tfar[packet.count - 1] = static_cast<float>(length - kOffSurface_m);
    if (packet.count == kPacket) flush();
  }
  if (packet.count > 0) flush();
}

double CabinScene::albedo(const CabinHit& hit) const {
  const CabinMaterial& material = cockpit_->meshes[hit.mesh].material;
  const double pattern = pattern_at(hit.place, material.grain_m, material.seed);
  return std::clamp(material.albedo * (1 + material.contrast * pattern), 0.02, 0.95);
}

}  // namespace raybundle
