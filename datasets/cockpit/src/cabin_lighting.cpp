// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "cabin_lighting.hpp"

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

constexpr double kSunDistance_m = 100;

// Mirrored light over the lobe of a rough surface. Source: Blinn 1977, normalised.
double mirrored(const CabinMaterial& material, const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                const Eigen::Vector3d& to_eye) {
  if (material.specular == 0) return 0;
  const double cosine = std::max(0.0, normal.dot((to_light + to_eye).normalized()));
  return material.specular * (material.gloss + 8) / 8 * std::pow(cosine, material.gloss);
}

}  // namespace

CabinLighting::CabinLighting(const CabinScene& scene, const CabinSensor& sensor)
    : scene_(&scene),
      illuminator_W_m2_(sensor.illuminator_W_m2),
      lamp_(sensor.vehicle_from_rig * (0.5 * sensor.rig.cameras.back().camera_from_rig.inverse().translation)),
      axis_(sensor.vehicle_from_rig.rotation * Eigen::Vector3d::UnitZ()),
      sun_(kSunDistance_m * scene.cockpit().light.sun_direction) {}

double CabinLighting::lamp_W_m2(const CabinHit& hit) const {
  const Eigen::Vector3d way = hit.x_in_vehicle - lamp_;
  const double distance = way.norm(), off_axis = std::max(0.0, way.dot(axis_) / distance);
  return illuminator_W_m2_ * off_axis * std::max(0.0, -way.dot(hit.normal) / distance) / (distance * distance);
}

void CabinLighting::shine(const Eigen::Vector3d& eye, std::span<const CabinHit> hits, std::span<float> light) const {
  const CabinLight& cabin = scene_->cockpit().light;
  std::vector<std::uint8_t> lamp_dark(hits.size(), 1), sun_dark(hits.size(), 1);
  if (illuminator_W_m2_ > 0) scene_->blocked(hits, lamp_, lamp_dark);
  if (cabin.sun_W_m2 > 0) scene_->blocked(hits, sun_, sun_dark);
  for (std::size_t i = 0; i < hits.size(); ++i) {
    light[i] = 0;
    const CabinHit& hit = hits[i];
    if (hit.mesh < 0) continue;
    const CabinMaterial& material = scene_->cockpit().meshes[hit.mesh].material;
    const double albedo = scene_->albedo(hit);
    const Eigen::Vector3d to_eye = (eye - hit.x_in_vehicle).normalized();
    double sum = albedo * cabin.ambient_W_m2;
    const auto add = [&](double W_m2, const Eigen::Vector3d& source) {
      sum += W_m2 * (albedo + mirrored(material, hit.normal, (source - hit.x_in_vehicle).normalized(), to_eye));
    };
    if (!lamp_dark[i]) add(lamp_W_m2(hit), lamp_);
    if (!sun_dark[i]) add(cabin.sun_W_m2 * std::max(0.0, hit.normal.dot(cabin.sun_direction)), sun_);
    light[i] = static_cast<float>(sum);
  }
}

}  // namespace raybundle
