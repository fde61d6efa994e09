// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "held_out.hpp"
#include "shapes.hpp"

namespace raybundle::held_out {
namespace {

// Half widths of a man of 1.75 m; others are as wide as `girth` says.
void set_girth(BodySize& size, double girth, double belly) {
  size.chest_depth = 0.125 * girth;
  size.chest_breadth = 0.160 * girth;
  size.waist_depth = 0.120 * girth * belly;
  size.waist_breadth = 0.150 * girth;
  size.pelvis_depth = 0.115 * girth;
  size.pelvis_breadth = 0.185 * girth;
  size.neck_radius = 0.060 * girth;
  size.arm_radius = 0.052 * girth;
  size.wrist_radius = 0.032 * girth;
  size.thigh_radius = 0.085 * girth;
  size.knee_radius = 0.060 * girth;
  size.ankle_radius = 0.040 * girth;
}

struct Measures {
  double stature = 0, sitting_height = 0, buttock_knee = 0, knee_height = 0, shoulders = 0, hips = 0;  // [m]
  Eigen::Vector3d head = Eigen::Vector3d::Zero();  // length, breadth, vertex to chin [m]
};

BodySize body_of(const Measures& m) {
  BodySize size;
  size.stature = m.stature;
  size.head_semi_axes = 0.5 * m.head;
  size.neck_to_head = 0.5 * m.head.z() + 0.05 * m.sitting_height;
  const double hips_to_neck = 0.90 * m.sitting_height - 0.5 * m.head.z() - size.neck_to_head;
  size.hip_to_waist = 0.36 * hips_to_neck;
  size.waist_to_neck = 0.64 * hips_to_neck;
  size.shoulder_half = 0.5 * m.shoulders;
  size.hip_half = 0.25 * m.hips;
  size.upper_arm = 0.40 * m.sitting_height * m.stature / 1.75;
  size.forearm = 0.29 * m.sitting_height * m.stature / 1.75;
  size.hand = 0.15 * m.sitting_height;
  size.thigh = 0.73 * m.buttock_knee;
  size.shank = 0.78 * m.knee_height;
  size.foot = 0.32 * m.buttock_knee;
  return size;
}

// Source: DIN 33402-2:2005, means of adults, rounded, with a scatter of proportions of their own; heads: ISO 7250.
Measures adult(Random& random) {
  const bool female = random.chance(0.5);
  const double z = normal_quantile(random.uniform(0.05, 0.95));
  const auto scatter = [&](double value) { return value * (1 + 0.02 * random.normal()); };
  Measures m;
  m.stature = female ? 1.625 + 0.056 * z : 1.75 + 0.062 * z;
  const double scale = m.stature / (female ? 1.625 : 1.75);
  m.sitting_height = scatter((female ? 0.870 : 0.910) * scale);
  m.buttock_knee = scatter((female ? 0.585 : 0.600) * scale);
  m.knee_height = scatter((female ? 0.500 : 0.535) * scale);
  m.shoulders = scatter((female ? 0.365 : 0.400) * scale);
  m.hips = scatter((female ? 0.385 : 0.360) * scale);
  m.head = female ? Eigen::Vector3d(0.185, 0.149, 0.215) : Eigen::Vector3d(0.194, 0.155, 0.226);
  m.head *= 1 + 0.025 * random.normal();
  return m;
}

// A child between 0.6 and 1.45 m. Source: the sizes of the test dummies of UN R129 (Q0 to Q10), interpolated.
Measures child(double stature) {
  struct Dummy {
    double stature, sitting_height, head_length, head_breadth, head_height;
  };
  static constexpr Dummy kDummies[] = {{0.62, 0.40, 0.140, 0.110, 0.150},
                                       {0.74, 0.475, 0.158, 0.125, 0.168},
                                       {0.985, 0.545, 0.174, 0.134, 0.188},
                                       {1.143, 0.601, 0.178, 0.139, 0.200},
                                       {1.443, 0.733, 0.187, 0.144, 0.212}};
  const Dummy* high = std::ranges::find_if(kDummies + 1, std::end(kDummies) - 1,
                                           [&](const Dummy& dummy) { return dummy.stature >= stature; });
  const Dummy& a = high[-1];
  const double t = (stature - a.stature) / (high->stature - a.stature);
  const auto mix = [t](double x, double y) { return x + t * (y - x); };
  Measures m;
  m.stature = stature;
  m.sitting_height = mix(a.sitting_height, high->sitting_height);
  const double legs = stature - m.sitting_height;
  m.buttock_knee = 0.70 * legs;
  m.knee_height = 0.60 * legs;
  m.shoulders = 0.225 * stature;
  m.hips = 0.195 * stature;
  m.head = {mix(a.head_length, high->head_length), mix(a.head_breadth, high->head_breadth),
            mix(a.head_height, high->head_height)};
  return m;
}

CabinMaterial look(double albedo, double contrast, double grain_m, Random& random) {
  return {.albedo = albedo,
          .contrast = contrast,
          .grain_m = grain_m,
          .seed = static_cast<std::uint32_t>(random.below(1 << 30))};
}

struct Flesh {
  Meshes& meshes;

  void add(const Eigen::Vector3d& centre, const Eigen::Quaterniond& axes, const Eigen::Vector3d& semi, CabinPart part,
           const CabinMaterial& material) {
    const int longitudes = part == CabinPart::kHead ? 28 : semi.minCoeff() > 0.09 ? 24 : 14;  // as fine as it is thick
    meshes.push_back(placed(ellipsoid(semi, longitudes), {axes, centre}, part, material));
  }

  // A chain of overlapping ellipsoids from joint to joint, thickest near the first one.
  void add_chain(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius, double end_radius,
                 double clothes_m, const CabinMaterial& material) {
    const Eigen::Vector3d along = to - from;
    const double length = along.norm();
    const Eigen::Quaterniond axes = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along);
    for (const double t : {0.08, 0.36, 0.64, 0.92}) {
      const double r = radius + t * (end_radius - radius) + clothes_m;
      add(from + t * along, axes, {r, r, std::max(0.26 * length, r)}, CabinPart::kBody, material);
    }
  }
};

bool is_grown(const BodySize& size) { return size.thigh + size.shank > 0.72; }

// Hips in the seat, the back against it.
Posture leaning_back(const BodySize& size, const SeatSetting& seat, Random& random) {
  const double slouch = random.chance(0.3) ? random.uniform(0.03, 0.10) : 0.0;
  Posture p;
  p.hips =
      seat.h_point + Eigen::Vector3d(slouch + 0.5 * std::max(0.0, size.waist_depth - 0.13), 0.025 * random.normal(), 0);
  if (!is_grown(size)) p.hips.z() -= 0.06 * (1 - size.stature / 1.7);
  p.pelvis_recline_rad = seat.recline_rad + 0.1 + 3.0 * slouch + 0.05 * random.normal();
  p.chest_recline_rad = seat.recline_rad - 0.12 + 0.06 * random.normal();
  p.lean_left_rad = random.chance(0.25) ? random.uniform(-0.20, -0.08) : 0.04 * random.normal();  // against the door
  p.turn_left_rad = 0.08 * random.normal();
  p.head_pitch_rad = random.uniform(-0.15, 0.5);
  p.head_turn_left_rad = random.uniform(-0.7, 0.7);
  return p;
}

// Hands lie on the thighs, are folded, before the chest, or hang; feet stand on the floor, or before the cushion where
// legs are short.
void rest_limbs(const BodySize& size, const CabinLayout& layout, Random& random, Posture& p) {
  const int pastime = random.below(4);
  const double ahead[] = {0.30, 0.15, 0.33, 0.05}, across[] = {0.14, 0.02, 0.05, 0.26},
               above[] = {0.12, 0.16, 0.33, 0.02};
  const bool grown = is_grown(size);
  for (int side = 0; side < 2; ++side) {
    const double left = side == 0 ? 1 : -1;
    p.hands[side] = p.hips +
                    Eigen::Vector3d(ahead[pastime] * size.stature / 1.75, left * across[pastime],
                                    size.thigh_radius + above[pastime] * size.stature / 1.75 - 0.02) +
                    0.02 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    p.feet[side] = grown
                       ? Eigen::Vector3d(std::min(layout.dashboard_x_m + 0.15,
                                                  p.hips.x() + random.uniform(0.70, 0.86) * (size.thigh + size.shank)),
                                         p.hips.y() + left * random.uniform(0.05, 0.20), -0.19)
                       : Eigen::Vector3d(p.hips + Eigen::Vector3d(0.93 * (size.thigh + size.shank), left * 0.08, 0.0));
    p.toes[side] = grown ? Eigen::Vector3d(1, 0.3 * left, -0.2) : Eigen::Vector3d(0.5, 0.1 * left, 0.9);
  }
}

}  // namespace

Person person(Age age, Random& random) {
  Person person;
  Measures measures;
  double girth = 1.0;
  switch (age) {
    case Age::kAdult:
      measures = adult(random);
      girth = random.uniform(0.88, 1.18) * std::sqrt(measures.stature / 1.75);
      break;
    case Age::kSchoolchild:
      measures = child(random.uniform(1.08, 1.44));
      girth = random.uniform(0.62, 0.74) * measures.stature / 1.25;
      break;
    case Age::kToddler:
      measures = child(random.uniform(0.84, 1.04));
      girth = random.uniform(0.54, 0.62) * measures.stature / 0.95;
      break;
    case Age::kBaby:
      measures = child(random.uniform(0.62, 0.82));
      girth = random.uniform(0.46, 0.54) * measures.stature / 0.72;
      break;
  }
  person.size = body_of(measures);
  set_girth(person.size, girth, age == Age::kAdult ? random.uniform(0.9, 1.35) : 1.0);
  person.skin = look(random.uniform(0.40, 0.70), 0.15, 0.007, random);
  person.hair = look(random.uniform(0.06, 0.55), 0.35, 0.005, random);
  person.shirt = fabric(random, 0.12, 0.9);
  person.trousers = fabric(random, 0.08, 0.8);
  person.shoes = fabric(random, 0.06, 0.7);
  person.cap = random.chance(0.08);
  person.clothes_m = random.uniform(0.003, 0.028) * std::min(1.0, measures.stature / 1.5);
  return person;
}

Posture posture(const BodySize& size, Sitting sitting, const SeatSetting& seat, const CabinLayout& layout,
                Random& random) {
  Posture p = leaning_back(size, seat, random);
  rest_limbs(size, layout, random, p);
  const double dash = layout.dashboard_x_m, top = layout.dashboard_top_m;
  const auto on_dashboard = [&](double y_low, double y_high) {
    return Eigen::Vector3d(dash + 0.02, random.uniform(y_low, y_high), top + random.uniform(-0.10, 0.06));
  };
  switch (sitting) {
    case Sitting::kNormal:
      break;
    case Sitting::kLeaningForward:
      p.pelvis_recline_rad = random.uniform(-0.3, 0.0);
      p.chest_recline_rad = -random.uniform(0.25, 1.0);
      p.head_pitch_rad = random.uniform(-0.2, 0.9);
      p.hands = {Eigen::Vector3d(p.hips + Eigen::Vector3d(0.42, 0.15, 0.12)),
                 p.hips + Eigen::Vector3d(0.42, -0.15, 0.12)};
      break;
    case Sitting::kHeadOnDashboard:
      p.hips.x() += random.uniform(0.10, 0.28);
      p.pelvis_recline_rad = -random.uniform(0.2, 0.5);
      p.chest_recline_rad = -random.uniform(0.8, 1.2);
      p.head_pitch_rad = random.uniform(0.2, 1.2);
      p.hands = {on_dashboard(0.10, 0.25), on_dashboard(-0.25, -0.10)};
      break;
    case Sitting::kFeetUp: {
      const int first = random.below(2);
      for (int side = first; side < 2; ++side) {
        p.feet[side] = on_dashboard(side == 0 ? 0.02 : -0.25, side == 0 ? 0.25 : -0.02) + Eigen::Vector3d(0.0, 0, 0.05);
        p.toes[side] = {0.5, 0, 1};
      }
      break;
    }
    case Sitting::kReachingForward:
      p.chest_recline_rad = random.uniform(-0.6, 0.0);
      p.hands[0] = on_dashboard(0.05, 0.35);
      if (random.chance(0.5)) p.hands[1] = on_dashboard(-0.25, 0.0);
      break;
    case Sitting::kTurned: {
      const double way = random.chance(0.6) ? 1 : -1;
      p.turn_left_rad = way * random.uniform(0.3, 1.0);
      p.hips.x() += 0.06;  // the shoulder needs room
      p.chest_recline_rad -= 0.15 * std::abs(p.turn_left_rad);
      p.lean_left_rad = way * random.uniform(-0.2, 0.3);
      p.head_turn_left_rad = way * random.uniform(0.2, 1.0);
      break;
    }
    case Sitting::kOnTheEdge:
      p.hips.x() += random.uniform(0.15, 0.30);
      p.pelvis_recline_rad = 0.1 * random.normal();
      p.chest_recline_rad = random.uniform(-0.4, 0.05);
      break;
    case Sitting::kKneeling:  // standing in front of the seat, leaning on the dashboard
      p.hips = {dash - random.uniform(0.24, 0.42), random.uniform(-0.12, 0.12), random.uniform(0.12, 0.26)};
      p.pelvis_recline_rad = random.uniform(-0.3, 0.1);
      p.chest_recline_rad = random.uniform(-0.5, 0.0);
      p.feet = {Eigen::Vector3d(p.hips.x() - 0.05, p.hips.y() + 0.08, -0.20),
                Eigen::Vector3d(p.hips.x() - 0.05, p.hips.y() - 0.08, -0.20)};
      p.hands = {on_dashboard(0.05, 0.25), on_dashboard(-0.25, -0.05)};
      break;
  }
  return p;
}

void add_person(const Person& person, const Skeleton& s, Meshes& meshes) {
  const BodySize& size = person.size;
  const double cloth_m = person.clothes_m, chest_length = (s.neck - s.waist).norm();
  Flesh flesh{meshes};
  const double forward = std::max(0.0, size.waist_depth - 0.13);  // bellies grow to the front
  const Eigen::Vector3d over = Eigen::Vector3d::Constant(cloth_m);
  const auto on_chest = [&](double up, double ahead) -> Eigen::Vector3d {
    return s.waist + s.vehicle_from_chest * Eigen::Vector3d(ahead, 0, up * chest_length);
  };
  flesh.add(s.hips + 0.02 * Eigen::Vector3d::UnitZ(), s.vehicle_from_pelvis,
            over + Eigen::Vector3d(size.pelvis_depth, size.pelvis_breadth, 0.62 * size.pelvis_breadth),
            CabinPart::kBody, person.trousers);
  flesh.add(
      0.4 * s.hips + 0.6 * s.waist + s.vehicle_from_pelvis * Eigen::Vector3d(0.1 * size.waist_depth + forward, 0, 0),
      s.vehicle_from_pelvis,
      over + Eigen::Vector3d(size.waist_depth, size.waist_breadth, 0.75 * size.hip_to_waist + 0.04 * size.stature),
      CabinPart::kBody, person.shirt);
  flesh.add(on_chest(0.15, forward), s.vehicle_from_chest,
            over + Eigen::Vector3d(size.waist_depth, size.waist_breadth, 0.35 * chest_length), CabinPart::kBody,
            person.shirt);
  flesh.add(on_chest(0.52, 0.01), s.vehicle_from_chest,
            over + Eigen::Vector3d(size.chest_depth, size.chest_breadth, 0.46 * chest_length), CabinPart::kBody,
            person.shirt);
  flesh.add(on_chest(0.80, -0.01), s.vehicle_from_chest,
            over + Eigen::Vector3d(0.65 * size.chest_depth, size.shoulder_half, 0.18 * chest_length), CabinPart::kBody,
            person.shirt);
  flesh.add(0.5 * (s.neck + s.head.centre), s.vehicle_from_chest,
            {size.neck_radius, size.neck_radius, 0.6 * size.neck_to_head}, CabinPart::kBody, person.skin);

  const Eigen::Vector3d& a = s.head.semi_axes;
  const auto on_head = [&](const Eigen::Vector3d& place) -> Eigen::Vector3d {
    return s.head.centre + s.head.vehicle_from_head * place;
  };
  meshes.push_back(
      placed(rounded_box(a, 0.92), {s.head.vehicle_from_head, s.head.centre}, CabinPart::kHead, person.skin));
  flesh.add(on_head({-0.12 * a.x(), 0, 0.10 * a.z()}), s.head.vehicle_from_head,
            {0.97 * a.x(), 1.07 * a.y(), 0.97 * a.z()}, CabinPart::kHead, person.hair);
  flesh.add(on_head({0.92 * a.x(), 0, -0.05 * a.z()}), s.head.vehicle_from_head, {0.022, 0.016, 0.03}, CabinPart::kHead,
            person.skin);
  if (person.cap)
    flesh.add(on_head({0, 0, 0.62 * a.z()}), s.head.vehicle_from_head, {1.5 * a.x(), 1.6 * a.y(), 0.08 * a.z()},
              CabinPart::kHead, person.shirt);

  for (int side = 0; side < 2; ++side) {
    flesh.add_chain(s.shoulders[side], s.elbows[side], 1.1 * size.arm_radius, 0.85 * size.arm_radius, cloth_m,
                    person.shirt);
    flesh.add_chain(s.elbows[side], s.wrists[side], 0.88 * size.arm_radius, size.wrist_radius, 0.5 * cloth_m,
                    person.shirt);
    const Eigen::Quaterniond hand =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), s.hand_tips[side] - s.wrists[side]);
    flesh.add(0.5 * (s.wrists[side] + s.hand_tips[side]), hand,
              {0.5 * size.wrist_radius + 0.003, 1.4 * size.wrist_radius, 0.6 * size.hand}, CabinPart::kBody,
              person.skin);
    flesh.add_chain(s.hip_joints[side], s.knees[side], size.thigh_radius, size.knee_radius, 0.6 * cloth_m,
                    person.trousers);
    flesh.add_chain(s.knees[side], s.ankles[side], size.knee_radius, size.ankle_radius, 0.6 * cloth_m, person.trousers);
    const Eigen::Quaterniond foot =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), s.toes[side] - s.ankles[side]);
    flesh.add(0.5 * (s.ankles[side] + s.toes[side]), foot,
              {size.ankle_radius + 0.005, size.ankle_radius + 0.01, 0.5 * size.foot + size.ankle_radius},
              CabinPart::kBody, person.shoes);
  }
}

}  // namespace raybundle::held_out
