// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "random_rig.hpp"

namespace raybundle::testing {
namespace {

constexpr double kRadian = M_PI / 180.0;

constexpr std::array kSizes{ImageSize{640, 480},  ImageSize{752, 480},   ImageSize{1024, 1024}, ImageSize{1280, 720},
                            ImageSize{1280, 960}, ImageSize{1920, 1080}, ImageSize{2448, 2048}};

/// How the parameters of a kind of lens are drawn, by name; `reach` is the plane's radius at the rim of the field.
double random_shape(std::string_view model, std::string_view name, double half_field_rad, Draw& draw) {
  const bool fisheye = model == "kannala_brandt";
  const double reach = fisheye ? half_field_rad : std::tan(std::min(half_field_rad, 70 * kRadian));
  const auto share_at_rim = [&](double low, double high, int power) {
    return draw.uniform(low, high) / std::pow(reach, power);
  };
  const bool wide = half_field_rad > 50 * kRadian;
  if (model == "unified") {
    if (name == "xi") return draw.uniform(wide ? 0.6 : 0.0, 1.8);
    if (name == "k1") return draw.uniform(-0.15, 0.15);
    if (name == "k2") return draw.uniform(-0.1, 0.1);
    return draw.normal(0.0007);
  }
  if (name == "alpha") return draw.uniform(wide ? 0.4 : -0.1, 0.75);
  if (name == "beta") return draw.uniform(0.7, 1.5);
  if (name == "xi") return draw.uniform(-0.35, 0.5);
  if (name == "w") return draw.uniform(0.2, 1.5);
  if (name == "p1" || name == "p2") return draw.normal(0.0007);
  if (name[0] == 's') return share_at_rim(-0.003, 0.003, name == "s1" || name == "s3" ? 1 : 3);
  if (fisheye) return share_at_rim(-0.2, 0.2, 2 * (name[1] - '0'));
  if (model == "brown_conrady") {
    if (name == "k1") return share_at_rim(-0.4, 0.15, 2);
    return share_at_rim(-0.1, 0.15, name == "k2" ? 4 : 6);
  }
  // Rational: the denominator bends a rectilinear lens into a fisheye, the numerator follows it.
  if (name == "k4") return draw.uniform(0.0, 1.5);
  if (name == "k5") return draw.uniform(0.0, 0.6);
  if (name == "k6") return draw.uniform(0.0, 0.05);
  if (name == "k1") return draw.uniform(-0.3, 1.2);
  if (name == "k2") return draw.uniform(0.0, 0.4);
  if (name == "k3") return draw.uniform(0.0, 0.03);
  throw std::logic_error("nothing is known of how to draw " + std::string(model) + "." + std::string(name));
}

/// Slope of radius against angle over that on the axis; 0 where the model does not project.
double relative_slope(const Camera& camera, double angle_rad) {
  const auto radius = [&](double angle) {
    const auto pixel = pixel_from_ray(camera, Eigen::Vector3d(std::sin(angle), 0, std::cos(angle)));
    return pixel ? pixel->x() - camera.cx() : std::nan("");
  };
  const double step = 1e-4;
  const double slope = (radius(angle_rad + step) - radius(angle_rad)) / (radius(step) - radius(0));
  return std::isfinite(slope) ? slope : 0.0;
}

/// Angle up to which the image is drawn as by a real lens: neither squeezed below a quarter of the scale on the axis,
/// nor drawn out to its eightfold.
double usable_angle(const Camera& camera) {
  const double limit = 0.98 * max_angle_rad(camera);
  double angle = 0.0;
  for (; angle < std::min(limit, 110 * kRadian); angle += 0.5 * kRadian) {
    const double slope = relative_slope(camera, angle);
    if (slope < 0.25 || slope > 8.0) break;
  }
  return std::max(0.0, angle - 0.5 * kRadian);
}

double widest_half_field(std::string_view model) {  // where lenses of the kind are still of use
  static const std::map<std::string_view, double> degrees{
      {"pinhole", 60}, {"brown_conrady", 62}, {"rational", 70}, {"thin_prism", 70}};
  const auto found = degrees.find(model);
  return (found == degrees.end() ? 100.0 : found->second) * kRadian;
}

}  // namespace

Camera random_camera(ModelId model, Draw& draw, double& half_field_rad) {
  const std::string_view name = model_name(model);
  for (int attempt = 0; attempt < 10000; ++attempt) {
    const double half_rad = draw.uniform(20 * kRadian, widest_half_field(name));
    Camera camera = start_camera(model, draw.pick(kSizes), 1.0);
    const std::vector<std::string_view> names = parameter_names(model);
    for (std::size_t k = 4; k < names.size(); ++k) {
      camera.parameters[static_cast<Eigen::Index>(k)] = random_shape(name, names[k], half_rad, draw);
    }
    camera.parameters.head<2>().setOnes();
    const double usable = usable_angle(camera);
    if (usable < half_rad) continue;
    const auto rim = pixel_from_ray(camera, Eigen::Vector3d(std::sin(half_rad), 0, std::cos(half_rad)));
    const double half_side = 0.5 * std::max(camera.size.width, camera.size.height);
    // The image circle of a wide fisheye may end inside of the image.
    const bool circle = half_rad > 65 * kRadian && draw.chance(0.5);
    const double focal = half_side * (circle ? draw.uniform(0.75, 1.0) : 1.0) / (rim->x() - camera.cx());
    const double aspect = draw.chance(0.5) ? 1.0 : draw.uniform(0.9, 1.1);
    camera.parameters.head<2>() << focal, aspect * focal;
    const double off = draw.chance(0.3) ? 0.01 : 0.1;
    camera.parameters[2] += draw.uniform(-off, off) * camera.size.width;
    camera.parameters[3] += draw.uniform(-off, off) * camera.size.height;
    half_field_rad = circle ? half_rad : usable;
    return camera;
  }
  throw std::logic_error("no lens of model " + std::string(name) + " could be drawn");
}

}  // namespace raybundle::testing
