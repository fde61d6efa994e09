// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/rectification.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

constexpr double kMostPinholeField_rad = 2.8;  // 160 degrees: the rim is sampled 33 times as densely as the centre
constexpr int kMostPixels = 1 << 26;

constexpr double degrees(double radians) { return radians * 180.0 / M_PI; }
std::string rounded(double value) { return std::to_string(static_cast<long>(std::lround(value))); }

// Places along a side of so many pixels, its edges among them: half a pixel beyond the middles of the outermost pixels.
double from_edge_to_edge(int i, int count, int pixels) { return i * static_cast<double>(pixels) / (count - 1) - 0.5; }

// Middles of as many equal parts of it: each stands for the same share of the image.
double middle_of_part(int i, int count, int pixels) { return (i + 0.5) * pixels / count - 0.5; }

// Unit rays of a grid of places in the image, in the rectified frame. At an edge that the lens does not reach, the
// outermost pixel's middle stands for it.
std::vector<Eigen::Vector3d> rays_of(const Camera& camera, const Eigen::Quaterniond& rectified_from_camera, int count,
                                     double (*place)(int, int, int)) {
  const auto [width, height] = camera.size;
  std::vector<Eigen::Vector3d> rays;
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d pixel(place(i, count, width), place(j, count, height));
      auto ray = ray_from_pixel(camera, pixel);
      if (!ray) {
        ray =
            ray_from_pixel(camera, {std::clamp(pixel.x(), 0.0, width - 1.0), std::clamp(pixel.y(), 0.0, height - 1.0)});
      }
      if (ray) rays.push_back(rectified_from_camera * *ray);
    }
  }
  return rays;
}

struct Range {
  double low = 0.0;  // the z axis is always inside
  double high = 0.0;
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double span() const { return high - low; }
};

// Angles of the rays that at least one camera sees: x along the baseline, y about it. Behind the cameras and near the
// poles, a lens of more than 180 degrees sees all angles about the baseline; they say nothing about the field's height.
struct Field {
  Range x, y;
};
Field field_of(const std::vector<Eigen::Vector3d>& rays) {
  constexpr double kNearPole = M_PI_4;
  Field field;
  for (const Eigen::Vector3d& ray : rays) {
    const double x = std::asin(std::clamp(ray.x(), -1.0, 1.0));
    if (ray.z() > 0 || std::abs(x) < kNearPole) field.y.include(std::atan2(ray.y(), ray.z()));
    field.x.include(x);
  }
  return field;
}

// The box of a pinhole image that holds all rays that a pinhole image can hold.
Field slopes_of(const std::vector<Eigen::Vector3d>& rays) {
  const double most = std::tan(kMostPinholeField_rad / 2);
  Field slopes;
  for (const Eigen::Vector3d& ray : rays) {
    if (!(ray.head<2>().cwiseAbs().maxCoeff() < most * ray.z())) continue;
    slopes.x.include(ray.x() / ray.z());
    slopes.y.include(ray.y() / ray.z());
  }
  return slopes;
}

Eigen::Matrix3d rectified_axes(const RigCamera& left, const RigCamera& right, double& baseline_m) {
  const Rigid3 rig_from_left = left.camera_from_rig.inverse();
  const Rigid3 rig_from_right = right.camera_from_rig.inverse();
  const Eigen::Vector3d baseline = rig_from_right.translation - rig_from_left.translation;
  baseline_m = baseline.norm();
  const std::string where = left.name + " and " + right.name;
  if (!(baseline_m > 1e-6)) {
    throw Error(ErrorKind::kBadInput,
                "the cameras are at one place, which gives no depth; give two cameras that are apart", where);
  }
  const Eigen::Vector3d x = baseline / baseline_m;
  const Eigen::Vector3d forward =
      rig_from_left.rotation * Eigen::Vector3d::UnitZ() + rig_from_right.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d z = forward - forward.dot(x) * x;
  if (!(z.norm() > 0.2)) {
    throw Error(ErrorKind::kBadInput,
                "the cameras look along the line that joins them or away from each other; a pair has to look across it",
                where);
  }
  Eigen::Matrix3d rig_from_rectified;
  rig_from_rectified << x, z.normalized().cross(x), z.normalized();
  if (rig_from_rectified.col(0).dot(rig_from_left.rotation * Eigen::Vector3d::UnitX() +
                                    rig_from_right.rotation * Eigen::Vector3d::UnitX()) < -0.2) {
    throw Error(ErrorKind::kBadInput,
                "'" + left.name + "' is to the right of '" + right.name + "'; swap the two: --left " + right.name +
                    " --right " + left.name,
                where);
  }
  return rig_from_rectified;
}

// Pixels for each radian around a ray, the geometric mean of the directions; 0 where the camera does not see it.
double density(const Camera& camera, const Eigen::Vector3d& ray) {
  constexpr double kStep = 1e-4;
  const auto at = pixel_from_ray(camera, ray);
  const auto right = pixel_from_ray(camera, ray + kStep * ray.unitOrthogonal());
  const auto down = pixel_from_ray(camera, ray + kStep * ray.cross(ray.unitOrthogonal()));
  if (!at || !right || !down) return 0.0;
  Eigen::Matrix2d step;
  step << *right - *at, *down - *at;
  return std::sqrt(std::abs(step.determinant())) / kStep;
}

RectifiedProjection chosen_projection(const RectifyOptions& options, const Field& field) {
  if (options.projection) return *options.projection;
  const double seen = std::max(options.field_x_rad > 0 ? options.field_x_rad : field.x.span(),
                               options.field_y_rad > 0 ? options.field_y_rad : field.y.span());
  return seen <= kPinholeAdvisedField_rad ? RectifiedProjection::kPinhole
                                          : RectifiedProjection::kTransverseEquirectangular;
}

// The box of image-plane coordinates (slopes or angles) that the images show.
Field shown_box(RectifiedProjection projection, const RectifyOptions& options, const Field& field,
                const std::vector<Eigen::Vector3d>& rays) {
  Field box = field;
  if (projection == RectifiedProjection::kPinhole) {
    const double seen_x = options.field_x_rad > 0 ? options.field_x_rad : 2 * std::max(-field.x.low, field.x.high);
    const double seen_y = options.field_y_rad > 0 ? options.field_y_rad : 2 * std::max(-field.y.low, field.y.high);
    if (std::max(seen_x, seen_y) > kMostPinholeField_rad) {
      throw Error(ErrorKind::kBadInput,
                  "a pinhole image cannot hold the field of " + rounded(degrees(seen_x)) + "° x " +
                      rounded(degrees(seen_y)) +
                      "°; choose the equirectangular projection, or limit the field to less than 160°");
    }
    box = slopes_of(rays);
  }
  const auto limit = [&](Range& range, double whole_rad) {
    if (!(whole_rad > 0)) return;
    const double half = projection == RectifiedProjection::kPinhole ? std::tan(whole_rad / 2) : whole_rad / 2;
    range = {-half, half};
  };
  limit(box.x, options.field_x_rad);
  limit(box.y, options.field_y_rad);
  return box;
}

RectifiedCamera camera_for(RectifiedProjection projection, const Field& box, const RectifyOptions& options,
                           double natural_focal_px) {
  if (options.width_px < 0 || options.height_px < 0) {
    throw Error(ErrorKind::kBadInput, "the size of a rectified image cannot be negative");
  }
  RectifiedCamera camera;
  camera.projection = projection;
  camera.focal_px = natural_focal_px;
  if (options.width_px > 0 && options.height_px > 0) {
    camera.focal_px = std::min(options.width_px / box.x.span(), options.height_px / box.y.span());
  } else if (options.width_px > 0 || options.height_px > 0) {
    camera.focal_px = options.width_px > 0 ? options.width_px / box.x.span() : options.height_px / box.y.span();
  }
  const auto pixels = [&](int wanted, const Range& range) {
    return wanted > 0 ? wanted : static_cast<int>(std::min(1e6, std::ceil(range.span() * camera.focal_px - 1e-6)));
  };
  camera.size = {pixels(options.width_px, box.x), pixels(options.height_px, box.y)};
  if (camera.size.width < 16 || camera.size.height < 16 ||
      static_cast<long>(camera.size.width) * camera.size.height > kMostPixels) {
    throw Error(ErrorKind::kBadInput, "a rectified image of " + std::to_string(camera.size.width) + "x" +
                                          std::to_string(camera.size.height) +
                                          " pixels is of no use; give another width or field");
  }
  camera.centre_px = 0.5 * Eigen::Vector2d(camera.size.width - 1, camera.size.height - 1) -
                     0.5 * camera.focal_px * Eigen::Vector2d(box.x.low + box.x.high, box.y.low + box.y.high);
  return camera;
}

double kept_share(const RectifiedCamera& camera, const std::vector<Eigen::Vector3d>& rays) {
  const auto kept = std::count_if(rays.begin(), rays.end(), [&](const Eigen::Vector3d& ray) {
    const auto pixel = camera.pixel_from_ray(ray);
    return pixel && camera.contains(*pixel);
  });
  return rays.empty() ? 0.0 : static_cast<double>(kept) / static_cast<double>(rays.size());
}

void state_field(Rectification& pair) {
  const RectifiedCamera& camera = pair.camera;
  const Eigen::Vector2d low = (Eigen::Vector2d(-0.5, -0.5) - camera.centre_px) / camera.focal_px;
  const Eigen::Vector2d high =
      (Eigen::Vector2d(camera.size.width - 0.5, camera.size.height - 0.5) - camera.centre_px) / camera.focal_px;
  const bool pinhole = camera.projection == RectifiedProjection::kPinhole;
  const auto angle = [&](double plane, double limit) {
    return pinhole ? std::atan(plane) : std::clamp(plane, -limit, limit);
  };
  pair.field_x_rad = angle(high.x(), M_PI_2) - angle(low.x(), M_PI_2);
  pair.field_y_rad = angle(high.y(), M_PI) - angle(low.y(), M_PI);
  const double rim = std::max(-low.x(), high.x());
  pair.rim_over_centre = pinhole ? 1.0 + rim * rim : 1.0;
}

}  // namespace

Rectification rectify(const RigCamera& left, const RigCamera& right, const RectifyOptions& options) {
  if (options.field_x_rad > M_PI) {
    throw Error(ErrorKind::kBadInput,
                "a field of " + rounded(degrees(options.field_x_rad)) +
                    "° along the baseline does not exist: from pole to pole there are 180°; give less along it, and up "
                    "to 360° across it");
  }
  Rectification pair;
  const Eigen::Matrix3d axes = rectified_axes(left, right, pair.baseline_m);
  const Eigen::Quaterniond rectified_from_rig(Eigen::Matrix3d(axes.transpose()));
  pair.rectified_from_left = (rectified_from_rig * left.camera_from_rig.rotation.conjugate()).normalized();
  pair.rectified_from_right = (rectified_from_rig * right.camera_from_rig.rotation.conjugate()).normalized();
  pair.rig_from_rectified = {rectified_from_rig.conjugate(), left.camera_from_rig.inverse().translation};

  std::vector<Eigen::Vector3d> rays =
      rays_of(left.camera, pair.rectified_from_left, options.samples_per_side, from_edge_to_edge);
  const std::vector<Eigen::Vector3d> right_rays =
      rays_of(right.camera, pair.rectified_from_right, options.samples_per_side, from_edge_to_edge);
  rays.insert(rays.end(), right_rays.begin(), right_rays.end());
  const Field field = field_of(rays);
  const RectifiedProjection projection = chosen_projection(options, field);
  const Field box = shown_box(projection, options, field, rays);

  const double natural_focal_px =
      std::max(density(left.camera, pair.rectified_from_left.conjugate() * Eigen::Vector3d::UnitZ()),
               density(right.camera, pair.rectified_from_right.conjugate() * Eigen::Vector3d::UnitZ()));
  if (!(natural_focal_px > 0) || !(box.x.span() > 0) || !(box.y.span() > 0)) {
    throw Error(ErrorKind::kBadInput, "neither camera sees the middle between the two; they do not look the same way",
                left.name + " and " + right.name);
  }
  pair.camera = camera_for(projection, box, options, natural_focal_px);
  pair.kept_left =
      kept_share(pair.camera, rays_of(left.camera, pair.rectified_from_left, options.samples_per_side, middle_of_part));
  pair.kept_right = kept_share(
      pair.camera, rays_of(right.camera, pair.rectified_from_right, options.samples_per_side, middle_of_part));
  state_field(pair);
  return pair;
}

}  // namespace raybundle
