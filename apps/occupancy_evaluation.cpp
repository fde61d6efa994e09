// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "occupancy_evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "occupancy_chain.hpp"
#include "raybundle/geometry/threads.hpp"
#include "raybundle/occupancy/seat_fit.hpp"

namespace raybundle::apps {
namespace {

constexpr double kNear_m = 0.6;  // distances beyond do not matter to any decision

// The true distance of the dot whose measured distance was told, NaN when it is not one of somebody; and of the dot of
// somebody that is nearest, of those that are in the zones, and clear of the dashboard, by more than it is known where
// the sensor is.
struct NearestDots {
  double told_m = NAN, nearest_m = INFINITY;
};

struct Trial {
  CockpitTruth truth;
  Occupancy answer;
  NearestDots dots;
};

bool on_seat(CabinPart part) {
  return part != CabinPart::kCar && part != CabinPart::kDashboard && part != CabinPart::kSeat;
}

NearestDots nearest_dots(const MeasuredScene& scene, const ZoneCount& told, const ZoneOptions& zones) {
  constexpr double kBorder_m = 0.01;
  NearestDots dots;
  for (std::size_t i = 0; i < scene.true_points.size(); ++i) {
    if (!on_seat(scene.parts[i])) continue;
    const Eigen::Vector3d& x = scene.true_points[i];
    const double distance = std::max(0.0, scene.layout.dashboard_x_m - x.x());
    const double measured = std::max(0.0, scene.layout.dashboard_x_m - scene.points[i].x_in_vehicle.x());
    if (measured == told.distance_m) dots.told_m = distance;
    const bool in_zones =
        x.z() > scene.layout.zone_floor_m + kBorder_m && std::abs(x.y()) < scene.layout.zone_half_width_m - kBorder_m;
    if (in_zones && distance > zones.dashboard_m + kBorder_m) dots.nearest_m = std::min(dots.nearest_m, distance);
  }
  return dots;
}

// The seat before anybody sat down on it: the same seed is the same car with the same seat.
SeatWatch empty_seat(ChainSource& source, const CockpitRequest& cockpit, const EvaluationOptions& options) {
  SeatWatch watch;
  for (int frame = 0; frame < options.empty_frames; ++frame) {
    const double time_s = (frame - options.empty_frames) * options.frame_s;
    const MeasuredScene scene = source.measured(
        CabinScene(make_cockpit({cockpit.generator, cockpit.seed, CabinClass::kEmpty, time_s})), time_s);
    watch.add(fit_seat(scene.layout, scene.scan()));
  }
  return watch;
}

/// @param seat  before the first frame
template <typename Source>
Trial trial(const CaseBase& base, const EvaluationOptions& options, Source source, SeatWatch seat = {}) {
  Trial trial;
  std::optional<OccupancyMonitor> monitor;
  for (int frame = 0; frame < options.frames; ++frame) {
    const MeasuredScene scene = source.at(frame * options.frame_s);
    if (!monitor) monitor.emplace(scene.layout, base, scene.rays, options.monitor);
    if (options.kind == SensorKind::kStereo) seat.add(fit_seat(scene.layout, scene.scan()));
    trial.answer = monitor->process(scene.scan(), seat.pose());
    trial.truth = scene.truth;
    trial.dots = nearest_dots(scene, trial.answer.zones, options.monitor.zones);
  }
  return trial;
}

int force_of(CabinDecision decision) { return 2 - static_cast<int>(decision); }

int force_of(AirbagAction action) { return std::max(0, static_cast<int>(action) - 1); }

bool somebody(CabinClass seat_class) {
  return seat_class != CabinClass::kEmpty && seat_class != CabinClass::kEmptyBooster &&
         seat_class != CabinClass::kObjects;
}

void count(bool is, Share& share) {
  share.count += is;
  ++share.trials;
}

void count_answer(int truth, int answer, Share& right, Share& rejected) {
  count(answer < 0, rejected);
  if (answer >= 0) count(answer == truth, right);
}

void add(const Trial& trial, Evaluation& sum) {
  const CockpitTruth& truth = trial.truth;
  const Occupancy& answer = trial.answer;
  const int seat_class = static_cast<int>(truth.seat_class), group = static_cast<int>(truth.group),
            decision = static_cast<int>(truth.decision);
  const int action = answer.action == AirbagAction::kUndecided ? -1 : 2 - force_of(answer.action);
  ++sum.scenes;
  ++sum.classes[seat_class][answer.situation < 0 ? kCabinClasses : answer.situation];
  ++sum.groups[group][answer.group < 0 ? 3 : answer.group];
  ++sum.actions[decision][action < 0 ? 3 : action];
  count_answer(seat_class, answer.situation, sum.right_class, sum.rejected_class);
  count_answer(group, answer.group, sum.right_group, sum.rejected_group);
  count_answer(decision, action, sum.right_action, sum.rejected_action);
  const bool harder = action >= 0 && force_of(answer.action) > force_of(truth.decision);
  count(harder && somebody(truth.seat_class), sum.dangerous);
  count(harder && !somebody(truth.seat_class), sum.wasted);
  if (!somebody(truth.seat_class) || !answer.zones.anything || truth.dashboard_distance_m > kNear_m) return;
  const double right_m = std::isfinite(trial.dots.told_m) ? trial.dots.told_m : trial.dots.nearest_m;
  if (std::isfinite(right_m)) sum.distance_errors_m.push_back(answer.zones.distance_m - right_m);
  if (trial.dots.nearest_m < kNear_m) count(trial.dots.nearest_m < answer.zones.distance_m - 0.02, sum.nearer_missed);
  sum.nearest_errors_m.push_back(answer.zones.distance_m - truth.dashboard_distance_m);
}

}  // namespace

MonitorOptions monitor_options_of(SensorKind kind) {
  MonitorOptions options;
  options.sure_of_force = 0.95;
  if (kind == SensorKind::kStructuredLight) {
    options.zones.margin_m = 0.10;  // people reach on between the dots
  } else {
    options.dense = true;
    options.zones = kDenseZones;
    options.moving = 0.10;  // wrong matches and rims alone move 7 % of the points of things at rest
    options.zones.margin_m = 0.03;
  }
  return options;
}

Evaluation evaluate(const CaseBase& base, const EvaluationOptions& options) {
  std::vector<Trial> trials(static_cast<std::size_t>(options.scenes));
  for_each_index(trials.size(), options.threads, [&](std::size_t i) {
    const SceneRequest request{options.kind, {options.generator, options.seed + i, {}, 0.0}, options.grid};
    if (options.kind == SensorKind::kStereo) {
      ChainSource source(request);
      const SeatWatch seat = empty_seat(source, request.cockpit, options);
      trials[i] = trial(base, options, std::move(source), seat);
    } else {
      trials[i] =
          options.chain ? trial(base, options, ChainSource(request)) : trial(base, options, SceneSource(request));
    }
    if (options.scene_done) options.scene_done();
  });
  Evaluation sum;
  for (const Trial& trial : trials) add(trial, sum);
  const auto by_size = [](double a, double b) { return std::abs(a) < std::abs(b); };
  std::ranges::sort(sum.distance_errors_m, by_size);
  std::ranges::sort(sum.nearest_errors_m, by_size);
  return sum;
}

}  // namespace raybundle::apps
