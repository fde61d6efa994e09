// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "occupancy_scenes.hpp"
#include "raybundle/geometry/wilson.hpp"
#include "raybundle/occupancy/monitor.hpp"

namespace raybundle::apps {

/// Thresholds for a sensor's points. They were chosen on scenes of the training generator only.
MonitorOptions monitor_options_of(SensorKind kind);

struct EvaluationOptions {
  SensorKind kind = SensorKind::kStructuredLight;
  CockpitGenerator generator = CockpitGenerator::kTraining;
  LaserGrid grid{11, 11};
  std::uint64_t seed = 0;  ///< of the first scene; learnt scenes must have others
  int scenes = 1000;
  int frames = 3;        ///< of each scene; the last one is judged
  double frame_s = 0.1;  ///< between frames
  int empty_frames = 3;  ///< of stereo, before: the seat is fitted while nobody sits on it
  MonitorOptions monitor;
  bool chain = false;  ///< laser: images are rendered and the runtime makes points of them, as always for stereo
  int threads = 1;
  std::function<void()> scene_done = {};  ///< called after each scene, from any thread
};

/// A share of trials with its 95 % confidence interval.
struct Share {
  int count = 0;
  int trials = 0;

  double value() const { return trials == 0 ? 0.0 : static_cast<double>(count) / trials; }
  double low() const { return wilson_bound(value(), trials, -1.96); }  ///< with high: 95 %
  double high() const { return wilson_bound(value(), trials, 1.96); }
};

/// How the monitor did on simulated cabins.
struct Evaluation {
  int scenes = 0;
  std::array<std::array<int, kCabinClasses + 1>, kCabinClasses> classes{};  ///< truth × answer; last: no answer
  std::array<std::array<int, 4>, 3> groups{};                               ///< truth × answer; last: no answer
  std::array<std::array<int, 4>, 3> actions{};   ///< CabinDecision × answer in that order; last: undecided
  Share right_class, right_group, right_action;  ///< of the answers given
  Share rejected_class, rejected_group, rejected_action;
  /// More forceful than right, with a person or a baby seat on the seat.
  Share dangerous;
  Share wasted;                           ///< fired where nobody is: empty seats, empty boosters, objects
  std::vector<double> distance_errors_m;  ///< to the true place of the dot told, of people within 0.6 m; sorted by size
  Share nearer_missed;                    ///< of them, a dot nearer by more than 20 mm was measured, and not told
  std::vector<double> nearest_errors_m;   ///< to the nearest place of the person, seen or not; sorted by size
};

Evaluation evaluate(const CaseBase& base, const EvaluationOptions& options);

/// Tables for people.
std::string text_from_evaluation(const std::string& title, const Evaluation& evaluation);

/// JSON of it: docs/formats/occupancy.md.
std::string json_from_evaluations(const std::vector<std::pair<std::string, Evaluation>>& evaluations);

}  // namespace raybundle::apps
