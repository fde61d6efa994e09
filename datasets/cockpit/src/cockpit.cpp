// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/cockpit/cockpit.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "blanket.hpp"
#include "dashboard_distance.hpp"
#include "family.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

// What is drawn from the same stream does not change when something else is drawn differently.
enum Stream : std::uint64_t { kClass, kLayout, kSeat, kCar, kLight, kThings, kBlanket, kPerson };
constexpr int kMostAttempts = 100;

struct Occupant {
  Person person;
  Posture posture;
};

// Slow swaying of trunk, head and hands.
Posture swayed(Posture posture, double amount, Random& random, double time_s) {
  const auto sway = [&](double size) {
    const double frequency_hz = random.uniform(0.15, 0.6), phase = random.uniform(0.0, 2 * M_PI);
    return amount * size * std::sin(2 * M_PI * frequency_hz * time_s + phase);
  };
  posture.chest_recline_rad += sway(0.04);
  posture.lean_left_rad += sway(0.03);
  posture.head_turn_left_rad += sway(0.25);
  posture.head_pitch_rad += sway(0.10);
  for (Eigen::Vector3d& hand : posture.hands) {
    const double along = sway(0.03), across = sway(0.02), up = sway(0.02);
    hand += Eigen::Vector3d(along, across, up);
  }
  return posture;
}

Posture seated_child(const BodySize& size, const ChildPlace& place, Random& random) {
  Posture p;
  const double ahead = place.looks_back ? -1.0 : 1.0;
  p.facing_rad = place.looks_back ? M_PI : 0.0;
  p.hips = place.hips;
  p.pelvis_recline_rad = place.recline_rad + 0.1;
  p.chest_recline_rad = place.recline_rad - random.uniform(0.0, 0.12);
  p.lean_left_rad = 0.06 * random.normal();
  p.head_pitch_rad = std::max(0.0, 0.5 * place.recline_rad) * -1.0 + random.uniform(-0.1, 0.3);
  p.head_turn_left_rad = 0.35 * random.normal();
  for (int side = 0; side < 2; ++side) {
    const double left = side == 0 ? ahead : -ahead;
    p.hands[side] = p.hips + Eigen::Vector3d(ahead * random.uniform(0.06, 0.20), left * random.uniform(0.03, 0.12),
                                             size.thigh_radius + random.uniform(0.04, 0.12));
    p.feet[side] = p.hips + Eigen::Vector3d(ahead * random.uniform(0.80, 0.96) * (size.thigh + size.shank), left * 0.07,
                                            random.uniform(-0.06, 0.05));
    p.toes[side] = {0.5 * ahead, 0.2 * left, 1};
  }
  return p;
}

Sitting draw_sitting(CabinClass wanted, Age age, Random& random) {
  if (wanted == CabinClass::kPassenger) {
    const double which = random.uniform();
    return which < 0.75 ? Sitting::kNormal : which < 0.9 ? Sitting::kTurned : Sitting::kLeaningForward;
  }
  static constexpr Sitting kOutside[] = {Sitting::kLeaningForward,  Sitting::kHeadOnDashboard, Sitting::kFeetUp,
                                         Sitting::kReachingForward, Sitting::kOnTheEdge,       Sitting::kKneeling};
  const auto count = static_cast<int>(std::size(kOutside)) - (age == Age::kAdult ? 1 : 0);  // adults do not kneel
  return kOutside[random.below(count)];
}

CabinLight draw_light(Random& random) {
  CabinLight light;
  light.ambient_W_m2 = random.uniform(0.05, 1.2);
  if (random.chance(0.35)) {
    light.sun_W_m2 = random.uniform(2.0, 20.0);
    const double azimuth = random.uniform(0.0, 2 * M_PI), height = random.uniform(0.35, 1.2);
    light.sun_direction = {std::cos(height) * std::cos(azimuth), std::cos(height) * std::sin(azimuth),
                           std::sin(height)};
  }
  return light;
}

// Heads rest on the dashboard, not in it, and elbows stay this side of the door.
bool fits(const Skeleton& skeleton, const CabinLayout& layout) {
  const Eigen::Vector3d& head = skeleton.head.centre;
  const double least = skeleton.head.semi_axes.minCoeff();
  const bool before = head.x()<layout.dashboard_x_m - least, above = head.z()> layout.dashboard_top_m + least;
  const bool neck_before = skeleton.neck.x() < layout.dashboard_x_m;
  const double elbow = std::min(skeleton.elbows[0].y(), skeleton.elbows[1].y());
  return (before || above) && neck_before && head.z() < layout.roof_m - least && elbow > layout.door_y_m;
}

// Draws a scene step by step.
class Drawing {
 public:
  explicit Drawing(const CockpitRequest& request)
      : request_(request),
        family_(request.generator == CockpitGenerator::kTraining ? training_family() : test_family()) {
    Random class_random = random(kClass), layout_random = random(kLayout), seat_random = random(kSeat),
           car_random = random(kCar), light_random = random(kLight);
    const int drawn = class_random.below(kCabinClasses);
    cockpit_.truth.seat_class = request.wanted.value_or(static_cast<CabinClass>(drawn));
    cockpit_.layout = family_.layout(layout_random);
    cockpit_.truth.seat = family_.seat_setting(cockpit_.layout, seat_random);
    family_.add_car(cockpit_.layout, car_random, cockpit_.meshes);
    family_.add_seat(cockpit_.truth.seat, seat_random, cockpit_.meshes);
    cockpit_.light = draw_light(light_random);
  }

  Cockpit finished() && {
    Random things = random(kThings);
    CockpitTruth& truth = cockpit_.truth;
    switch (truth.seat_class) {
      case CabinClass::kEmpty:
        break;
      case CabinClass::kPassenger:
      case CabinClass::kOutOfPosition:
        add_passenger();
        break;
      case CabinClass::kEmptyBooster:
        family_.add_booster(truth.seat, things, occupants_);
        break;
      case CabinClass::kChildInBooster:
        add_child(family_.add_booster(truth.seat, things, occupants_), Age::kSchoolchild);
        break;
      case CabinClass::kForwardBabySeat: {
        const ChildPlace place = family_.add_forward_baby_seat(truth.seat, things, occupants_);
        if (things.chance(0.7)) add_child(place, Age::kToddler);
        break;
      }
      case CabinClass::kRearBabySeat: {
        const ChildPlace place = family_.add_rear_baby_seat(truth.seat, things, occupants_);
        if (things.chance(0.7)) add_child(place, Age::kBaby);
        break;
      }
      case CabinClass::kObjects:
        family_.add_objects(truth.seat, things, occupants_);
        break;
    }
    add_blanket();
    truth.group = group_of(truth.seat_class);
    if (const auto nearest = nearest_to_dashboard(occupants_, cockpit_.layout)) {
      truth.nearest_place = *nearest;
      truth.dashboard_distance_m = std::max(0.0, cockpit_.layout.dashboard_x_m - nearest->x());
    }
    truth.decision = decision_of(truth.seat_class, truth.dashboard_distance_m, cockpit_.layout);
    std::ranges::move(occupants_, std::back_inserter(cockpit_.meshes));
    return std::move(cockpit_);
  }

 private:
  Random random(std::uint64_t stream) const { return Random(request_.seed, stream); }

  bool belongs(const Occupant& occupant) const {
    const Skeleton skeleton = skeleton_of(occupant.person.size, occupant.posture);
    if (!fits(skeleton, cockpit_.layout)) return false;
    Meshes meshes;
    family_.add_person(occupant.person, skeleton, meshes);
    const bool near = dashboard_distance(meshes, cockpit_.layout) < cockpit_.layout.out_of_position_m;
    return near == (cockpit_.truth.seat_class == CabinClass::kOutOfPosition);
  }

  // People and postures are drawn until they are as the class wants them, at the time zero: later they may sway into
  // another class.
  void add_passenger() {
    for (int attempt = 0; attempt < kMostAttempts; ++attempt) {
      Random person_random = random(kPerson + static_cast<std::uint64_t>(attempt));
      const Age age = person_random.chance(0.85) ? Age::kAdult : Age::kSchoolchild;
      Occupant occupant{family_.person(age, person_random), {}};
      const Sitting sitting = draw_sitting(cockpit_.truth.seat_class, age, person_random);
      occupant.posture =
          family_.posture(occupant.person.size, sitting, cockpit_.truth.seat, cockpit_.layout, person_random);
      Random still = person_random;
      const Posture posture = occupant.posture;
      occupant.posture = swayed(posture, 1.0, still, 0.0);
      if (!belongs(occupant)) continue;
      occupant.posture = swayed(posture, 1.0, person_random, request_.time_s);
      add(occupant);
      const double distance = dashboard_distance(occupants_, cockpit_.layout);
      cockpit_.truth.seat_class =
          distance < cockpit_.layout.out_of_position_m ? CabinClass::kOutOfPosition : CabinClass::kPassenger;
      return;
    }
    throw Error(ErrorKind::kSolveFailed, "no passenger of this cabin comes to sit as asked; take another seed");
  }

  void add_child(const ChildPlace& place, Age age) {
    Random person_random = random(kPerson);
    Occupant child{family_.person(age, person_random), {}};
    const Posture posture = seated_child(child.person.size, place, person_random);
    child.posture = swayed(posture, age == Age::kBaby ? 0.5 : 1.0, person_random, request_.time_s);
    add(child);
  }

  // Over the legs of children in their seats, and over objects.
  void add_blanket() {
    const CabinClass seat_class = cockpit_.truth.seat_class;
    const bool child = group_of(seat_class) == CabinGroup::kBabySeat || seat_class == CabinClass::kChildInBooster;
    Random blanket = random(kBlanket);
    if (!child && seat_class != CabinClass::kObjects) return;
    if (!blanket.chance(0.2)) return;
    Cockpit below = cockpit_;
    below.meshes.insert(below.meshes.end(), occupants_.begin(), occupants_.end());
    const Eigen::Vector3d centre = cockpit_.truth.seat.h_point + Eigen::Vector3d(blanket.uniform(0.24, 0.36), 0, 0);
    const CabinMaterial wool{.albedo = blanket.uniform(0.2, 0.8),
                             .contrast = blanket.uniform(0.1, 0.4),
                             .grain_m = 0.008,
                             .seed = static_cast<std::uint32_t>(blanket.below(1 << 30))};
    occupants_.push_back(draped_blanket(CabinScene(std::move(below)), centre, wool, blanket));
  }

  void add(const Occupant& occupant) {
    const Skeleton skeleton = skeleton_of(occupant.person.size, occupant.posture);
    family_.add_person(occupant.person, skeleton, occupants_);
    cockpit_.truth.head = skeleton.head;
  }

  CockpitRequest request_;
  const CabinFamily& family_;
  Cockpit cockpit_;
  Meshes occupants_;
};

}  // namespace

Cockpit make_cockpit(const CockpitRequest& request) { return Drawing(request).finished(); }

}  // namespace raybundle
