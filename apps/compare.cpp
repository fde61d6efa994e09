// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <map>
#include <memory>

#include "comparison_text.hpp"
#include "number_flags.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/number.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct CompareFlags {
  std::string a, b;
  std::vector<double> ranges_m;
  SigmasFrom sigmas_from = SigmasFrom::kCorners;
  int columns = 40;
  double max_px = 0.0;      // 0: no gate
  double max_sigmas = 0.0;  // 0: no gate
  bool json = false;
};

// What misses a gate, in words.
std::vector<std::string> missed_gates(const CompareFlags& flags, const CalibrationComparison& comparison) {
  std::vector<std::string> missed;
  for (const ProjectionDifference& d : comparison.projections) {
    const std::string lost = lost_text(d);
    if (flags.max_px > 0.0 && !lost.empty()) missed.push_back(lost + " (--max-px)");
    if (flags.max_px > 0.0 && d.largest_px > flags.max_px) {
      missed.push_back(fmt::format("{} {}: projections differ by up to {:.3f} px, and {:g} px are allowed (--max-px)",
                                   d.camera, range_text(d.range_m), d.largest_px, flags.max_px));
    }
    if (flags.max_sigmas <= 0.0) continue;
    if (!lost.empty()) missed.push_back(lost + " (--max-sigmas)");
    const double within = share_within(d, flags.max_sigmas);
    if (within >= kLeastShareWithin) continue;
    missed.push_back(fmt::format(
        "{} {}: only {:.0f} % of the image that both saw is within {:g} summed sigmas, and {:.0f} % have to "
        "be (--max-sigmas)",
        d.camera, range_text(d.range_m), 100.0 * within, flags.max_sigmas, 100 * kLeastShareWithin));
  }
  for (const auto* differences : {&comparison.extrinsics, &comparison.beams}) {
    for (const NormalizedDifference& d : *differences) {
      if (!(flags.max_sigmas > 0.0 && d.sigmas > flags.max_sigmas)) continue;
      missed.push_back(fmt::format("{} {}: {:.1f} sigmas apart, and {:g} are allowed (--max-sigmas)",
                                   differences == &comparison.beams ? "beam" : "extrinsics", d.name, d.sigmas,
                                   flags.max_sigmas));
    }
  }
  if (flags.max_sigmas > 0.0) {
    for (const std::string& lonely : comparison.not_compared) {
      missed.push_back(lonely + " (--max-sigmas)");
    }
  }
  return missed;
}

// What is wrong with the text of a distance; empty: nothing. CLI11's own check refuses infinity.
std::string positive_or_infinite(const std::string& text) {
  return number_from<double>(text).value_or(0.0) > 0.0 ? ""
                                                       : "'" + text + "' is no distance: write metres, as 0.5, or inf";
}

void run(const CompareFlags& flags) {
  const CalibrationFile a = read_calibration(flags.a), b = read_calibration(flags.b);
  ComparisonOptions options{.columns = flags.columns, .sigmas_from = flags.sigmas_from};
  if (!flags.ranges_m.empty()) options.ranges_m = flags.ranges_m;
  const CalibrationComparison comparison = compare(a.calibration, b.calibration, options);
  const std::vector<std::string> missed = missed_gates(flags, comparison);
  if (flags.json) {
    nlohmann::ordered_json json = json_from_comparison(comparison);
    json["a"] = flags.a;
    json["b"] = flags.b;
    json["passed"] = missed.empty();
    json["missed"] = missed;
    fmt::print("{}\n", text_of_json(json));
  } else {
    fmt::print("{}", comparison_text(comparison));
    if (flags.sigmas_from == SigmasFrom::kCorners && a.calibration.covariance_by_frame &&
        b.calibration.covariance_by_frame) {
      fmt::print("sigmas take every corner for an independent witness; --sigmas frames asks how the frames disagree\n");
    }
    for (const std::string& sentence : missed) fmt::print("FAIL  {}\n", sentence);
  }
  if (!missed.empty()) throw GateFailed{};
}

}  // namespace

void add_compare_verb(CLI::App& app) {
  auto flags = std::make_shared<CompareFlags>();
  CLI::App* verb =
      app.add_subcommand("compare", "two calibrations: how their images differ, and whether noise explains it");
  verb->add_option("a", flags->a, "calibration.json")->required()->type_name("CALIBRATION");
  verb->add_option("b", flags->b, "another one of the same cameras")->required()->type_name("CALIBRATION");
  verb->add_option("--range", flags->ranges_m, "distance of the points that are projected [m], inf for infinity")
      ->type_name("M")
      ->check(positive_or_infinite)
      ->allow_extra_args(false)
      ->default_str("inf");
  const std::map<std::string, SigmasFrom> kSources{{"corners", SigmasFrom::kCorners}, {"frames", SigmasFrom::kFrames}};
  verb->add_option("--sigmas", flags->sigmas_from, "where sigmas come from: corners, or how frames disagree")
      ->transform(CLI::CheckedTransformer(kSources))
      ->default_str("corners");
  verb->add_option("--columns", flags->columns, "cells of the difference map along the image's width")
      ->check(CLI::Range(4, 400))
      ->capture_default_str();
  verb->add_option("--max-px", flags->max_px, "gate: no projection of a camera that both have may differ by more [px]")
      ->check(above_zero);
  verb->add_option(
          "--max-sigmas", flags->max_sigmas,
          "gate: 90 % of the image within so many summed sigmas, every extrinsic and beam within so many sigmas, "
          "and nothing that cannot be compared")
      ->check(above_zero);
  verb->add_flag("--json", flags->json, "print the result as JSON, with the maps");
  verb->footer(
      "The rotation, and at finite ranges the translation, that no image tells from the rig's own place are taken "
      "out.\n"
      "Example:\n  raybundle compare monday/calibration.json friday/calibration.json --range 1 --range inf\n"
      "Exit code 1 when a gate is missed.");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
