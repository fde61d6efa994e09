// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/dots.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "raybundle/synthetic/random.hpp"

namespace raybundle {
namespace {

constexpr int kRing = 6;               // rays around a beam, one standard deviation off its axis
constexpr double kStep_m = 0.01;       // off the spot's plane: another surface
constexpr double kLeastCosine = 0.12;  // at flatter angles a spot is a streak
constexpr double kLeastRing = 0.5;     // of a spot must be left for it to be a spot
constexpr double kLeastSignal = 6.0;   // over the noise in the spot's area
constexpr double kFloor_px = 0.03;     // of any detector
constexpr double kFull = 0.95;         // of the well: such pixels are saturated

struct Spot {
  Eigen::Vector2d pixel;       // of the axis
  Eigen::Vector2d centroid;    // of what is left of it
  Eigen::Matrix2d spread_px2;  // of its image
  double electrons = 0.0;      // of the laser
  double under_e = 0.0;        // of other light, in a pixel
  double area_px() const { return 4 * M_PI * std::sqrt(spread_px2.determinant()); }
};

class DotMaker {
 public:
  DotMaker(const CabinScene& scene, const CabinSensor& sensor)
      : scene_(scene),
        emitter_(*sensor.rig.emitter),
        camera_(sensor.rig.cameras.front()),
        camera_from_vehicle_(camera_.camera_from_rig * sensor.vehicle_from_rig.inverse()),
        eye_(camera_from_vehicle_.inverse().translation) {}

  std::optional<Eigen::Vector2d> pixel_of(const Eigen::Vector3d& x_in_vehicle) const {
    const Eigen::Vector3d ray = camera_from_vehicle_ * x_in_vehicle;
    if (angle_off_axis(ray) > camera_.used_half_angle_rad) return std::nullopt;
    const auto pixel = pixel_from_ray(camera_.camera, ray);
    return pixel && camera_.camera.size.contains(*pixel) ? pixel : std::nullopt;
  }

  // Where a ray meets the plane that touches the surface at the hit.
  static std::optional<Eigen::Vector3d> on_plane(const CabinHit& hit, const Line3& ray) {
    const double slope = hit.normal.dot(ray.direction);
    if (std::abs(slope) < 1e-3) return std::nullopt;
    return ray.at(hit.normal.dot(hit.x_in_vehicle - ray.point) / slope);
  }

  std::optional<Spot> spot_of(const EmittedBeam& emitted, const Line3& beam, const CabinHit& hit) const {
    const Eigen::Vector3d to_eye = eye_ - hit.x_in_vehicle;
    const double cosine = -hit.normal.dot(beam.direction);
    if (cosine < kLeastCosine || hit.normal.dot(to_eye.normalized()) < kLeastCosine) return std::nullopt;
    const auto pixel = pixel_of(hit.x_in_vehicle);
    if (!pixel || scene_.blocked(hit.x_in_vehicle, eye_)) return std::nullopt;
    const double along = (hit.x_in_vehicle - beam.point).dot(beam.direction);
    const double sigma_m =
        0.5 * std::hypot(emitter_.spot_radius_m, emitter_.divergence_rad * (along - emitter_.waist_distance_m));
    const Eigen::Matrix<double, 3, 2> axes = across(beam.direction);
    Eigen::Matrix2d pixel_from_offset;
    for (int k = 0; k < 2; ++k) {
      const auto place = on_plane(hit, {beam.point + sigma_m * axes.col(k), beam.direction});
      const auto shifted = place ? pixel_of(*place) : std::nullopt;
      if (!shifted) return std::nullopt;
      pixel_from_offset.col(k) = *shifted - *pixel;
    }
    Spot spot;
    spot.pixel = *pixel;
    const double blur_px2 = camera_.sensor.lens_blur_px * camera_.sensor.lens_blur_px + 1.0 / 12.0;
    spot.spread_px2 = pixel_from_offset * pixel_from_offset.transpose() + blur_px2 * Eigen::Matrix2d::Identity();
    const double share = cut(spot, beam, hit, sigma_m, axes);
    if (share < kLeastRing) return std::nullopt;
    // Pixels for each square metre of the surface turn power into the sum of the pixels' light.
    const double pixels_per_m2 = std::abs(pixel_from_offset.determinant()) * cosine / (sigma_m * sigma_m);
    const double albedo = scene_.albedo(hit), per_W_m2 = electrons_per_W_m2(to_eye);
    spot.electrons = share * per_W_m2 * albedo * emitted.power_W * pixels_per_m2;
    spot.under_e = per_W_m2 * albedo * other_light(hit);
    return spot;
  }

  // Share of the spot that lies on the axis's surface; the centroid moves towards it.
  double cut(Spot& spot, const Line3& beam, const CabinHit& hit, double sigma_m,
             const Eigen::Matrix<double, 3, 2>& axes) const {
    int left = 1;
    Eigen::Vector2d sum = spot.pixel;
    for (int i = 0; i < kRing; ++i) {
      const double angle = 2 * M_PI * i / kRing;
      const Line3 ray{beam.point + sigma_m * (axes * Eigen::Vector2d(std::cos(angle), std::sin(angle))),
                      beam.direction};
      const auto met = scene_.first_hit(ray.point, ray.direction);
      const auto plane = on_plane(hit, ray);
      if (!met || !plane || (met->x_in_vehicle - *plane).norm() > kStep_m) continue;
      const auto pixel = pixel_of(met->x_in_vehicle);
      if (!pixel) continue;
      sum += *pixel;
      ++left;
    }
    spot.centroid = left == kRing + 1 ? spot.pixel : Eigen::Vector2d(sum / left);
    return static_cast<double>(left) / (kRing + 1);
  }

  // Thompson, Larson, Webb 2002, eq. 17, for a spot that is not round; speckle as independent gains of its pixels.
  std::optional<Dot> detected(const Spot& spot, int beam, Random& random) const {
    const SimulatedSensor& sensor = camera_.sensor;
    const double noise_e2 = spot.under_e + sensor.read_noise_e * sensor.read_noise_e;
    const double area = spot.area_px(), peak = 2 * spot.electrons / area;
    const bool seen =
        spot.electrons > kLeastSignal * std::sqrt(noise_e2 * area) && spot.under_e + peak < kFull * sensor.full_well_e;
    Dot dot;
    const double n = std::max(1.0, spot.electrons), c = emitter_.speckle_contrast;
    dot.covariance_px2 = (1 / n + 2 * area * noise_e2 / (n * n) + c * c / area) * spot.spread_px2 +
                         kFloor_px * kFloor_px * Eigen::Matrix2d::Identity();
    const double x = random.normal(), y = random.normal();
    dot.pixel = spot.centroid + dot.covariance_px2.llt().matrixL() * Eigen::Vector2d(x, y);
    dot.beam = beam;
    dot.brightness = n / sensor.full_well_e * (std::exp2(sensor.bits) - 1);
    return seen ? std::optional(dot) : std::nullopt;
  }

 private:
  double electrons_per_W_m2(const Eigen::Vector3d& to_eye) const {
    const SimulatedSensor& sensor = camera_.sensor;
    const double axis_cosine = (camera_from_vehicle_.rotation * -to_eye).normalized().z();
    const double vignetting = std::pow(std::sqrt(0.5 + 0.5 * axis_cosine), sensor.vignetting);
    return sensor.full_well_e * sensor.exposure * vignetting / sensor.white_W_m2;
  }

  double other_light(const CabinHit& hit) const {
    const CabinLight& light = scene_.cockpit().light;
    const double cosine = hit.normal.dot(light.sun_direction);
    const bool sunny = light.sun_W_m2 > 0 && cosine > 0 &&
                       !scene_.blocked(hit.x_in_vehicle, hit.x_in_vehicle + 5 * light.sun_direction);
    return light.ambient_W_m2 + (sunny ? light.sun_W_m2 * cosine : 0.0);
  }

  const CabinScene& scene_;
  const Emitter& emitter_;
  const SimulatedCamera& camera_;
  Rigid3 camera_from_vehicle_;
  Eigen::Vector3d eye_;
};

void add_spurious(const CabinSensor& sensor, double share, Random& random, std::vector<CabinDot>& dots) {
  const ImageSize size = sensor.rig.cameras.front().camera.size;
  const auto count = static_cast<int>(std::lround(share * static_cast<double>(dots.size())));
  for (int i = 0; i < count; ++i) {
    CabinDot dot;
    const double x = random.uniform(0, size.width - 1), y = random.uniform(0, size.height - 1);
    dot.dot.pixel = dot.true_pixel = {x, y};
    dot.dot.covariance_px2 = 0.01 * Eigen::Matrix2d::Identity();
    dot.dot.brightness = dots[static_cast<std::size_t>(random.below(static_cast<int>(dots.size())))].dot.brightness;
    dots.push_back(dot);
  }
}

// Distance along a beam to its point nearest to another line.
double nearest_along(const Line3& beam, const Line3& other) {
  const double cosine = beam.direction.dot(other.direction);
  const Eigen::Vector3d between = other.point - beam.point;
  return (beam.direction - cosine * other.direction).dot(between) / (1 - cosine * cosine);
}

}  // namespace

std::vector<CabinDot> dots_of(const CabinScene& scene, const CabinSensor& sensor, const CabinDotOptions& options) {
  const DotMaker maker(scene, sensor);
  Random random(options.seed, mixed_bits(options.stream) ^ 301);
  std::vector<CabinDot> dots;
  for (const EmittedBeam& emitted : beams_of(*sensor.rig.emitter)) {
    if (!emitted.labelled()) continue;
    const Line3 beam = sensor.vehicle_from_rig * emitted.line;
    const auto hit = scene.first_hit(beam.point, beam.direction);
    const auto spot = hit ? maker.spot_of(emitted, beam, *hit) : std::nullopt;
    if (!spot) continue;
    const auto dot = maker.detected(*spot, sensor.rig.emitter->grid.index(emitted.row, emitted.column), random);
    if (dot) dots.push_back({*dot, spot->pixel, hit->x_in_vehicle, scene.cockpit().meshes[hit->mesh].part});
  }
  add_spurious(sensor, options.spurious, random, dots);
  return dots;
}

std::vector<CabinPoint> points_of(const std::vector<CabinDot>& dots, const CabinSensor& sensor) {
  constexpr double kBeamSigma_m = 5e-4;
  const SimulatedCamera& camera = sensor.rig.cameras.front();
  const Rigid3 rig_from_camera = camera.camera_from_rig.inverse();
  std::vector<Line3> beams(static_cast<std::size_t>(sensor.rig.emitter->grid.size()));
  for (const EmittedBeam& emitted : beams_of(*sensor.rig.emitter)) {
    if (emitted.labelled()) beams[sensor.rig.emitter->grid.index(emitted.row, emitted.column)] = emitted.line;
  }
  std::vector<CabinPoint> points;
  for (const CabinDot& dot : dots) {
    if (dot.dot.beam == kUnlabelled) continue;
    const Line3& beam = beams[dot.dot.beam];
    const auto along = [&](const Eigen::Vector2d& pixel) -> std::optional<double> {
      const auto ray = ray_from_pixel(camera.camera, pixel);
      return ray ? std::optional(nearest_along(beam, rig_from_camera * Line3{Eigen::Vector3d::Zero(), *ray}))
                 : std::nullopt;
    };
    const auto at = along(dot.dot.pixel), right = along(dot.dot.pixel + Eigen::Vector2d(0.01, 0)),
               below = along(dot.dot.pixel + Eigen::Vector2d(0, 0.01));
    if (!at || !right || !below) continue;
    const Eigen::RowVector2d slope(100 * (*right - *at), 100 * (*below - *at));
    const double variance_m2 = slope * dot.dot.covariance_px2 * slope.transpose();
    const Line3 in_vehicle = sensor.known_vehicle_from_rig * beam;
    points.push_back({dot.dot.beam, in_vehicle.at(*at),
                      variance_m2 * in_vehicle.direction * in_vehicle.direction.transpose() +
                          kBeamSigma_m * kBeamSigma_m * Eigen::Matrix3d::Identity(),
                      dot.part});
  }
  return points;
}

}  // namespace raybundle
