// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "raybundle/occupancy/attributes.hpp"
#include "raybundle/occupancy/case_base.hpp"
#include "raybundle/occupancy/zones.hpp"

namespace raybundle {

struct MonitorOptions {
  ZoneOptions zones;
  /// Whether points show all that is in the zones. Then cases need only say who is there, which the frames of the last
  /// second do together, and the zones where; else every frame's cases say both.
  bool dense = false;
  double sure_of_force = 0.9;    ///< votes that an action must have in every space before it is taken for harmless
  double least_free = 0.14;      ///< share of the rays that must have crossed the zones before the airbag may fire
  double sure_of_no_fire = 0.5;  ///< votes that nobody may be fired at, before that is said
  double least_points = 0.25;    ///< share of the rays that must end somewhere; fewer: INVALID
  double good_points = 0.40;     ///< fewer: DEGRADED
  int memory_frames = 10;        ///< votes of the last so many frames say together who is there
  int calm_frames = 3;           ///< a more forceful action must have been right for so many frames
  double moved_sigmas = 5.0;     ///< a ray's end has moved when its range changed by more of its sigmas
  double moving = 0.04;          ///< share of the rays on the seat that moved, above which something lives there
};

/// What one frame and those before it tell.
struct Occupancy {
  State state = State::kInvalid;                   ///< INVALID: the action is kUndecided, and nothing else counts
  AirbagAction action = AirbagAction::kUndecided;  ///< the least forceful of the last frames
  int group = -1;                                  ///< index into CaseBase::group_names; -1: unsure
  int situation = -1;                              ///< index into CaseBase::situations; -1: unsure or unknown
  double confidence = 0.0;                         ///< votes of the likeliest situation
  ZoneCount zones;
  int free_rays = 0;    ///< that crossed the zones and ended beyond
  double moving = 0.0;  ///< share of the rays on the seat whose end moved since the last frame
  CaseVerdict verdict;  ///< of this frame alone
};

/// Watches a seat frame by frame: level 1 says who is there by the nearest learnt cases, level 2 where somebody is,
/// by the zones before the dashboard; both are fused to what the airbag may do.
///
/// Something in the critical zone forbids to fire whoever it is. A more forceful action than no fire is only taken
/// when the votes against it are few; votes that agree on nothing are INVALID, never a default. Who is there changes
/// rarely: the frames of the last second say that together; where somebody is, each frame says for itself. All memory
/// is taken by the constructor.
class OccupancyMonitor {
 public:
  /// @param rays  that the sensor has
  /// @throws Error(kBadInput) when the base is damaged or its attributes are unknown here
  OccupancyMonitor(const VehicleLayout& layout, CaseBase base, int rays, const MonitorOptions& options = {});

  /// @param measured  INVALID, and the frames before forgotten, when its rays are not those of the constructor
  /// @param seat      as it is set, as far as that is known: the cases' boxes move with it, and do not recline
  Occupancy process(const Scan& measured, const SeatPose& seat = {});

  /// Forgets the frames before.
  void restart();

  const CaseBase& base() const { return base_; }

 private:
  double moving_share(const Scan& scan);
  void vote(Occupancy& now);

  // What cases said of a frame.
  struct Said {
    std::array<double, kMostClasses> votes{};
    std::array<double, kAirbagActions> allowed{};  ///< see CaseVerdict::allowed_least
  };
  Said remembered(const Said& now);
  AirbagAction action_of(const Occupancy& now) const;
  AirbagAction calmed(AirbagAction now);

  VehicleLayout layout_;
  CaseBase base_;
  const AttributeSet* attributes_;
  MonitorOptions options_;
  std::vector<ScenePoint> clear_;     ///< points that are not on the car's fixtures
  std::vector<double> last_range_m_;  ///< of each ray; NaN: it did not end
  std::vector<double> range_m_;
  bool first_ = true;
  std::vector<AirbagAction> last_actions_;        ///< of the last calm_frames - 1 frames
  std::vector<Said> last_said_;                   ///< a ring of memory_frames
  std::size_t said_ = 0;                          ///< that were put into it
  std::array<double, kAirbagActions> allowed_{};  ///< what the action rests on
};

}  // namespace raybundle
