// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "shapes.hpp"
#include "training.hpp"

namespace raybundle::training {
namespace {

// Head and trunk by stature [m], rounded. Sources: Snyder et al. 1977 (UM-HSRI-77-17) for children, Pheasant 1996
// (Bodyspace) for adults; shares of limbs: Drillis and Contini 1966, as in Winter 2009, figure 4.1.
struct Growth {
  double stature, sitting_share, head_length, head_breadth, head_height;
};
constexpr Growth kGrowth[] = {{0.70, 0.630, 0.152, 0.120, 0.165}, {0.95, 0.570, 0.175, 0.135, 0.188},
                              {1.17, 0.545, 0.182, 0.140, 0.200}, {1.40, 0.530, 0.187, 0.143, 0.210},
                              {1.62, 0.528, 0.188, 0.146, 0.216}, {1.755, 0.520, 0.197, 0.152, 0.230},
                              {1.90, 0.516, 0.204, 0.157, 0.240}};

Growth growth_at(double stature) {
  const Growth* high = std::ranges::find_if(kGrowth + 1, std::end(kGrowth) - 1,
                                            [&](const Growth& growth) { return growth.stature >= stature; });
  const Growth& a = high[-1];
  const Growth& b = *high;
  const double t = (stature - a.stature) / (b.stature - a.stature);
  const auto mix = [t](double x, double y) { return x + t * (y - x); };
  return {stature, mix(a.sitting_share, b.sitting_share), mix(a.head_length, b.head_length),
          mix(a.head_breadth, b.head_breadth), mix(a.head_height, b.head_height)};
}

BodySize body_of(double stature, double mass_kg) {
  const Growth growth = growth_at(stature);
  const double h = stature, legs = h * (1 - growth.sitting_share) / 0.48;  // stature of an adult with such legs
  // Widths grow with the root of mass over stature: those of a man of 1.755 m and 77 kg are the unit.
  const double girth = std::sqrt(mass_kg / h / (77 / 1.755));
  BodySize size;
  size.stature = h;
  size.neck_to_head = 0.5 * growth.head_height + 0.035 * h;
  const double hips_to_neck = (growth.sitting_share - 0.052) * h - 0.5 * growth.head_height - size.neck_to_head;
  size.hip_to_waist = 0.40 * hips_to_neck;
  size.waist_to_neck = 0.60 * hips_to_neck;
  size.shoulder_half = 0.11 * h;
  size.hip_half = 0.05 * h;
  size.upper_arm = 0.186 * h;
  size.forearm = 0.146 * h;
  size.hand = 0.085 * h;
  size.thigh = 0.245 * legs;
  size.shank = 0.246 * legs;
  size.foot = 0.11 * legs;
  size.head_semi_axes = 0.5 * Eigen::Vector3d(growth.head_length, growth.head_breadth, growth.head_height);
  size.chest_depth = 0.118 * girth;
  size.chest_breadth = 0.165 * girth;
  size.waist_depth = 0.118 * girth * girth;  // the belly takes more than its part
  size.waist_breadth = 0.155 * girth;
  size.pelvis_depth = 0.11 * girth;
  size.pelvis_breadth = 0.18 * girth;
  size.neck_radius = 0.058 * girth;
  size.arm_radius = 0.050 * girth;
  size.wrist_radius = 0.030 * girth;
  size.thigh_radius = 0.082 * girth;
  size.knee_radius = 0.058 * girth;
  size.ankle_radius = 0.038 * girth;
  return size;
}

// Between the 5th and the 95th percentile.
double percentile_draw(Random& random, double mean, double deviation) {
  return mean + deviation * normal_quantile(random.uniform(0.05, 0.95));
}

struct Limbs {
  const Person& person;
  Meshes& meshes;

  void add(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, double end_radius,
           const CabinMaterial& material, double clothes_m) {
    meshes.push_back(limb(from, to, radius + clothes_m, end_radius + clothes_m, CabinPart::kBody, material));
  }

  // Side by side so that the cross-section is as broad as the trunk.
  void add_trunk(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Quaterniond& from_axes,
                 const Eigen::Quaterniond& to_axes, double depth, double end_depth, double breadth, double end_breadth,
                 const CabinMaterial& material) {
    for (const double side : {-1.0, 0.0, 1.0}) {
      add(from + from_axes * Eigen::Vector3d(0, side * std::max(0.0, breadth - depth), 0),
          to + to_axes * Eigen::Vector3d(0, side * std::max(0.0, end_breadth - end_depth), 0), depth, end_depth,
          material, person.clothes_m);
    }
  }
};

void add_head(const Person& person, const HeadTruth& head, Meshes& meshes) {
  const Rigid3 pose{head.vehicle_from_head, head.centre};
  const auto on_head = [&](const Eigen::Vector3d& place) { return Rigid3{pose.rotation, pose * place}; };
  const Eigen::Vector3d& a = head.semi_axes;
  meshes.push_back(placed(ellipsoid(a), pose, CabinPart::kHead, person.skin));
  meshes.push_back(placed(ellipsoid({0.98 * a.x(), 1.05 * a.y(), 0.90 * a.z()}), on_head({-0.016, 0, 0.018}),
                          CabinPart::kHead, person.hair));
  meshes.push_back(
      placed(ellipsoid({0.018, 0.013, 0.024}), on_head({a.x(), 0, -0.10 * a.z()}), CabinPart::kHead, person.skin));
  if (person.cap) {
    meshes.push_back(placed(rounded_box({0.07, 0.07, 0.006}, 0.6), on_head({a.x() + 0.03, 0, 0.45 * a.z()}),
                            CabinPart::kHead, person.shirt));
  }
}

bool has_long_legs(const BodySize& size) { return size.thigh > 0.36; }

// Hips in the seat, the back against it.
Posture leaning_back(const BodySize& size, const SeatSetting& seat, Random& random) {
  Posture p;
  p.hips = seat.h_point + Eigen::Vector3d(random.uniform(-0.01, 0.04) + 0.7 * std::max(0.0, size.waist_depth - 0.13),
                                          random.uniform(-0.03, 0.03), 0);
  p.hips.z() += 0.6 * std::max(0.0, size.pelvis_depth - 0.115);                 // thicker bodies sit higher
  if (!has_long_legs(size)) p.hips.z() -= 0.5 * (0.11 - size.pelvis_depth);     // and thinner ones lower
  const double slouch = random.chance(0.35) ? random.uniform(0.0, 0.12) : 0.0;  // hips slid to the front
  p.hips.x() += slouch;
  p.pelvis_recline_rad = seat.recline_rad + random.uniform(0.05, 0.20) + 2.5 * slouch;
  p.chest_recline_rad = seat.recline_rad - random.uniform(0.05, 0.22);
  p.lean_left_rad = random.chance(0.3) ? random.uniform(-0.22, 0.22) : 0.05 * random.normal();
  p.turn_left_rad = 0.08 * random.normal();
  p.head_pitch_rad = random.uniform(-0.15, 0.5);
  p.head_turn_left_rad = 0.4 * random.normal();
  return p;
}

// Hands rest on the thighs, meet on the belly, hold something before the chest, or lie beside the legs; feet stand on
// the floor, or before the cushion where legs are short.
void rest_limbs(const BodySize& size, const CabinLayout& layout, Random& random, Posture& p) {
  const int pastime = random.below(5);
  const double ahead = pastime < 2    ? random.uniform(0.16, 0.32)
                       : pastime == 4 ? random.uniform(0.0, 0.15)
                                      : random.uniform(0.12, 0.35);
  const double above = pastime < 3 ? random.uniform(0.07, 0.16) : pastime == 3 ? random.uniform(0.15, 0.40) : 0.03;
  const double apart = pastime == 4 ? random.uniform(0.20, 0.30) : random.uniform(0.0, 0.16);
  const bool long_legs = has_long_legs(size);
  for (int side = 0; side < 2; ++side) {
    const double left = side == 0 ? 1 : -1;
    p.hands[side] =
        p.hips + Eigen::Vector3d((ahead + random.uniform(-0.04, 0.04)) * size.stature / 1.75,
                                 left * (apart + random.uniform(-0.02, 0.03)),
                                 size.thigh_radius + (above + random.uniform(-0.02, 0.02)) * size.stature / 1.75);
    p.feet[side] = long_legs
                       ? Eigen::Vector3d(std::min(layout.dashboard_x_m + 0.12, p.hips.x() + 0.395 * size.stature) +
                                             random.uniform(-0.08, 0.04),
                                         p.hips.y() + left * random.uniform(0.06, 0.16), -0.21)
                       : Eigen::Vector3d(p.hips + Eigen::Vector3d(0.96 * (size.thigh + size.shank), left * 0.07, 0.04));
    p.toes[side] = long_legs ? Eigen::Vector3d(1, 0.2 * left, -0.15) : Eigen::Vector3d(0.4, 0.2 * left, 1);
  }
}

Eigen::Vector3d place_on_dashboard(const CabinLayout& layout, double y_low, double y_high, Random& random) {
  const double top = layout.dashboard_top_m;
  return Eigen::Vector3d(layout.dashboard_x_m - 0.02, random.uniform(y_low, y_high),
                         random.uniform(top - 0.15, top + 0.05));
}

// On the cushion, looking ahead or to the rear.
void kneel(const SeatSetting& seat, const CabinLayout& layout, Random& random, Posture& p) {
  const bool back = random.chance(0.5);
  p.facing_rad = back ? M_PI : 0.0;
  p.hips = {seat.h_point.x() + random.uniform(0.22, 0.42), random.uniform(-0.1, 0.1), random.uniform(0.05, 0.20)};
  p.pelvis_recline_rad = random.uniform(-0.1, 0.1);
  p.chest_recline_rad = random.uniform(-0.4, 0.1);
  for (int side = 0; side < 2; ++side) {
    const double left = (side == 0 ? 1 : -1) * (back ? -1 : 1);
    p.feet[side] = {p.hips.x() + (back ? 0.12 : 0.05), p.hips.y() + 0.08 * left, -0.22};
    p.toes[side] = {back ? -1.0 : 1.0, 0, -0.1};
    p.hands[side] = back ? Eigen::Vector3d(seat.h_point.x() + 0.05, 0.15 * left, 0.3)
                         : place_on_dashboard(layout, -0.25, 0.25, random);
  }
}

}  // namespace

Person person(Age age, Random& random) {
  Person person;
  double stature = 0, body_mass_index = 0;  // [kg/m²]
  switch (age) {
    case Age::kAdult: {
      const bool female = random.chance(0.5);
      stature = female ? percentile_draw(random, 1.62, 0.068) : percentile_draw(random, 1.755, 0.072);
      body_mass_index = std::clamp(percentile_draw(random, 25.5, 4.2), 18.5, 36.0);
      break;
    }
    case Age::kSchoolchild:
      stature = random.uniform(1.10, 1.42);
      body_mass_index = random.uniform(14.5, 19.0);
      break;
    case Age::kToddler:
      stature = random.uniform(0.86, 1.05);
      body_mass_index = random.uniform(14.5, 17.5);
      break;
    case Age::kBaby:
      stature = random.uniform(0.62, 0.80);
      body_mass_index = random.uniform(15.5, 18.0);
      break;
  }
  person.size = body_of(stature, body_mass_index * stature * stature);
  person.skin = {.albedo = random.uniform(0.45, 0.65),
                 .contrast = 0.12,
                 .grain_m = 0.008,
                 .seed = static_cast<std::uint32_t>(random.below(1 << 30))};
  person.hair = {.albedo = random.uniform(0.10, 0.45),
                 .contrast = 0.4,
                 .grain_m = 0.006,
                 .seed = static_cast<std::uint32_t>(random.below(1 << 30))};
  person.shirt = cloth(random, 0.10, 0.85);
  person.trousers = cloth(random, 0.08, 0.70);
  person.shoes = cloth(random, 0.08, 0.5);
  person.cap = random.chance(0.12);
  person.clothes_m = random.uniform(0.004, random.chance(0.2) ? 0.035 : 0.022) * std::min(1.0, stature / 1.4);  // coats
  return person;
}

Posture posture(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                Random& random) {
  Posture p = leaning_back(size, seat, random);
  rest_limbs(size, layout, random, p);
  const auto on_dashboard = [&](double y_low, double y_high) {
    return place_on_dashboard(layout, y_low, y_high, random);
  };
  switch (sitting) {
    case Sitting::kNormal:
      break;
    case Sitting::kLeaningForward:
      p.pelvis_recline_rad = random.uniform(-0.25, 0.1);
      p.chest_recline_rad = -random.uniform(0.3, 0.9);
      p.head_pitch_rad = random.uniform(0.0, 0.8);
      for (Eigen::Vector3d& hand : p.hands) hand.x() += random.uniform(0.05, 0.2);
      break;
    case Sitting::kHeadOnDashboard:
      p.hips.x() += random.uniform(0.08, 0.25);
      p.pelvis_recline_rad = -random.uniform(0.3, 0.6);
      p.chest_recline_rad = -random.uniform(0.7, 1.1);
      p.head_pitch_rad = random.uniform(0.4, 1.0);
      for (Eigen::Vector3d& hand : p.hands) hand = on_dashboard(-0.25, 0.25);
      break;
    case Sitting::kFeetUp:
      p.hips.x() += random.uniform(0.0, 0.10);
      for (int side = 0; side < 2; ++side) {
        if (side == 1 && random.chance(0.4)) break;  // the right foot stays down
        p.feet[side] =
            on_dashboard(side == 0 ? 0.05 : -0.22, side == 0 ? 0.22 : -0.05) + Eigen::Vector3d(-0.03, 0, 0.04);
        p.toes[side] = {0.3, 0, 1};
      }
      break;
    case Sitting::kReachingForward: {
      p.chest_recline_rad = random.uniform(-0.5, 0.1);
      const int side = random.below(2);
      p.hands[side] = on_dashboard(-0.2, 0.3);
      if (random.chance(0.4)) p.hands[1 - side] = on_dashboard(-0.25, 0.2);
      break;
    }
    case Sitting::kTurned:
      p.turn_left_rad = (random.chance(0.7) ? 1 : -1) * random.uniform(0.4, 1.1);
      p.hips.x() += 0.05;  // makes room for the shoulder before the seat's back
      p.chest_recline_rad -= 0.12 * std::abs(p.turn_left_rad);
      p.lean_left_rad += std::copysign(random.uniform(0.0, 0.35), p.turn_left_rad);
      p.head_turn_left_rad = std::copysign(random.uniform(0.0, 0.9), p.turn_left_rad);
      break;
    case Sitting::kOnTheEdge:
      p.hips.x() += random.uniform(0.12, 0.28);
      p.pelvis_recline_rad = random.uniform(-0.1, 0.2);
      p.chest_recline_rad = random.uniform(-0.3, 0.1);
      break;
    case Sitting::kKneeling:
      kneel(seat, layout, random, p);
      break;
  }
  return p;
}

void add_person(const Person& person, const Skeleton& s, Meshes& meshes) {
  const BodySize& size = person.size;
  Limbs limbs{person, meshes};
  const Eigen::Vector3d breast = s.waist + 0.62 * (s.neck - s.waist);
  const Eigen::Vector3d collar = s.neck - s.vehicle_from_chest * Eigen::Vector3d(0, 0, 0.045 * size.stature);
  limbs.add_trunk(s.hips, s.waist, s.vehicle_from_pelvis, s.vehicle_from_chest, size.pelvis_depth, size.waist_depth,
                  size.pelvis_breadth, size.waist_breadth, person.trousers);
  limbs.add_trunk(s.waist, breast, s.vehicle_from_chest, s.vehicle_from_chest, size.waist_depth, size.chest_depth,
                  size.waist_breadth, size.chest_breadth, person.shirt);
  limbs.add_trunk(breast, collar, s.vehicle_from_chest, s.vehicle_from_chest, size.chest_depth, 0.6 * size.chest_depth,
                  size.chest_breadth, size.shoulder_half, person.shirt);
  limbs.add(s.neck, s.head.centre, size.neck_radius, size.neck_radius, person.skin, 0);
  add_head(person, s.head, meshes);
  for (int side = 0; side < 2; ++side) {
    limbs.add(s.shoulders[side], s.elbows[side], 1.15 * size.arm_radius, 0.9 * size.arm_radius, person.shirt,
              person.clothes_m);
    limbs.add(s.elbows[side], s.wrists[side], 0.9 * size.arm_radius, size.wrist_radius, person.shirt,
              0.7 * person.clothes_m);
    limbs.add(s.wrists[side], s.hand_tips[side], 1.2 * size.wrist_radius, 0.8 * size.wrist_radius, person.skin, 0);
    limbs.add(s.hip_joints[side], s.knees[side], size.thigh_radius, size.knee_radius, person.trousers,
              0.7 * person.clothes_m);
    limbs.add(s.knees[side], s.ankles[side], size.knee_radius, size.ankle_radius, person.trousers,
              0.7 * person.clothes_m);
    limbs.add(s.ankles[side], s.toes[side], 1.1 * size.ankle_radius, 0.9 * size.ankle_radius, person.shoes, 0.005);
  }
}

}  // namespace raybundle::training
