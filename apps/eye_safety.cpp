// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "eye_safety_limits.hpp"
#include "number_flags.hpp"
#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "raybundle/scene/laser.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

constexpr const char* kNoVerdict =
    "These are formulas, not a compliance verdict: that takes measurements by the standard.";

struct SafetyFlags {
  LaserDrive drive;
  double pulse_us = 1000.0;
  std::string edition;
  std::optional<double> power_mW;
  int beams = 1;
  double brightest = 1.0;  // beam over the mean of all
  std::string calibration;
  bool json = false;
};

struct Judgement {
  SafetyLimit limit;
  int beams = 1;             // the laser is split into
  int in_aperture = 1;       // of them, at once
  double total_W = 0.0;      // that the laser may have, split
  double one_fault_W = 0.0;  // with the grating lost
};

const SafetyEdition& edition_of(const SafetyFlags& flags) {
  return *std::ranges::find(kSafetyEditions, flags.edition, &SafetyEdition::name);
}

// Beams that nothing determined leave the projector, too, as far as anybody knows: where the grating's model says.
std::vector<Line3> lines_of(const LaserPattern& laser) {
  std::vector<Line3> lines;
  std::vector<bool> determined(static_cast<std::size_t>(laser.grid.size()), false);
  for (const LaserBeam& beam : laser.beams) {
    lines.push_back(beam.line);
    determined[static_cast<std::size_t>(laser.grid.index(beam.row, beam.column))] = true;
  }
  for (int beam = 0; beam < laser.grid.size(); ++beam) {
    if (determined[static_cast<std::size_t>(beam)]) continue;
    const auto line = line_of_model(laser, laser.grid.row(beam), laser.grid.column(beam));
    if (line) lines.push_back(*line);
  }
  return lines;
}

// The power is taken to be shared by the beams that are surely there, which are the calibrated ones.
void take_beams(const std::string& path, double distance_m, Judgement& judgement) {
  const std::optional<LaserPattern> laser = read_calibration(path).calibration.laser;
  if (!laser || laser->beams.empty()) throw Error(ErrorKind::kBadInput, "holds no laser beams", path);
  judgement.beams = static_cast<int>(laser->beams.size());
  judgement.in_aperture = beams_in_aperture(lines_of(*laser), distance_m);
  if (laser->grating || judgement.beams == laser->grid.size()) return;
  say_warning(
      fmt::format("{} holds lines of {} of the grating's {} beams and no model of the others, which may enter the "
                  "aperture, too: the limit in all may be too high",
                  path, judgement.beams, laser->grid.size()));
}

Judgement judge(const SafetyFlags& flags) {
  const SafetyEdition& edition = edition_of(flags);
  Judgement judgement{.limit = safety_limit(flags.drive, edition), .beams = flags.beams};
  if (!flags.calibration.empty()) take_beams(flags.calibration, edition.distance_m, judgement);
  judgement.one_fault_W = judgement.limit.least_W();
  judgement.total_W = judgement.limit.least_W() * judgement.beams / (judgement.in_aperture * flags.brightest);
  return judgement;
}

void print_text(const SafetyFlags& flags, const Judgement& judgement) {
  const SafetyLimit& limit = judgement.limit;
  fmt::print("class 1, IEC 60825-1 edition {}, {} nm, pulses of {} µs at {} Hz, 7 mm aperture at {:.0f} mm\n",
             flags.edition, flags.drive.wavelength_nm, flags.pulse_us, flags.drive.rate_Hz,
             1e3 * edition_of(flags).distance_m);
  fmt::print("  a single pulse   {:8.3f} mW during the pulse (C4 {:.3f}, C6 {:.3f})\n", 1e3 * limit.single_pulse_W,
             limit.c4, limit.c6);
  fmt::print("  average power    {:8.3f} mW during the pulse\n", 1e3 * limit.average_W);
  fmt::print("  train of pulses  {:8.3f} mW during the pulse (C5 {:.3f}, {:.0f} pulses in {:.0f} s)\n",
             1e3 * limit.pulse_train_W, limit.c5, limit.pulses, limit.exposure_s);
  fmt::print("permissible through the aperture: {:.3f} mW\n", 1e3 * limit.least_W());
  fmt::print(
      "split into {} beams, of which {} at most enter the aperture, the brightest {} times the mean: {:.1f} mW in "
      "all\n",
      judgement.beams, judgement.in_aperture, flags.brightest, 1e3 * judgement.total_W);
  fmt::print("single fault, grating lost and all power in one beam: {:.3f} mW in all\n", 1e3 * judgement.one_fault_W);
  if (flags.power_mW) {
    const auto word = [&](double limit_W) { return 1e-3 * *flags.power_mW <= limit_W ? "within" : "ABOVE"; };
    fmt::print("{} mW is {} the limit as split, and {} it with the grating lost\n", *flags.power_mW,
               word(judgement.total_W), word(judgement.one_fault_W));
  }
  fmt::print("{}\n", kNoVerdict);
}

void print_json(const SafetyFlags& flags, const Judgement& judgement) {
  const SafetyLimit& limit = judgement.limit;
  nlohmann::ordered_json result{{"edition", flags.edition},
                                {"single_pulse_mW", 1e3 * limit.single_pulse_W},
                                {"average_mW", 1e3 * limit.average_W},
                                {"pulse_train_mW", 1e3 * limit.pulse_train_W},
                                {"permissible_mW", 1e3 * limit.least_W()},
                                {"c4", limit.c4},
                                {"c5", limit.c5},
                                {"c6", limit.c6},
                                {"exposure_s", limit.exposure_s},
                                {"beams", judgement.beams},
                                {"beams_in_aperture", judgement.in_aperture},
                                {"brightest_over_mean", flags.brightest},
                                {"permissible_total_mW", 1e3 * judgement.total_W},
                                {"permissible_total_grating_lost_mW", 1e3 * judgement.one_fault_W},
                                {"note", kNoVerdict}};
  fmt::print("{}\n", text_of_json(result, 2));
}

void run(SafetyFlags flags) {
  flags.drive.pulse_s = 1e-6 * flags.pulse_us;
  const Judgement judgement = judge(flags);
  flags.json ? print_json(flags, judgement) : print_text(flags, judgement);
  if (flags.power_mW && 1e-3 * *flags.power_mW > std::min(judgement.total_W, judgement.one_fault_W)) throw GateFailed{};
}

}  // namespace

void add_eye_safety_verb(CLI::App& app) {
  auto flags = std::make_shared<SafetyFlags>();
  CLI::App* verb = app.add_subcommand("eye-safety", "how much power a dot projector may have, by IEC 60825-1 class 1");
  std::vector<std::string> editions;
  for (const SafetyEdition& edition : kSafetyEditions) editions.emplace_back(edition.name);
  verb->add_option("--edition", flags->edition, "of the standard: they differ")
      ->required()
      ->check(CLI::IsMember(editions));
  verb->add_option("--wavelength", flags->drive.wavelength_nm, "[nm]")->check(above_zero)->capture_default_str();
  verb->add_option("--pulse", flags->pulse_us, "length of a pulse [µs]")->check(above_zero)->capture_default_str();
  verb->add_option("--rate", flags->drive.rate_Hz, "pulses in a second [Hz]")->check(above_zero)->capture_default_str();
  verb->add_option("--source", flags->drive.source_mrad, "apparent size of the source [mrad]")->capture_default_str();
  CLI::Option* beams = verb->add_option("--beams", flags->beams, "that the laser is split into");
  beams->check(CLI::Range(1, 1 << 20))->capture_default_str();
  verb->add_option("--brightest", flags->brightest,
                   "power of the brightest beam over the mean: gratings never split evenly")
      ->check(CLI::Range(1.0, 1e6))
      ->capture_default_str();
  verb->add_option("--calibration", flags->calibration,
                   "takes the beams from calibration.json, and counts those that "
                   "enter the aperture together")
      ->excludes(beams)
      ->type_name("CALIBRATION");
  verb->add_option("--power", flags->power_mW,
                   "of the laser during the pulse, to be judged: exit code 1 when above [mW]")
      ->check(above_zero)
      ->type_name("MW");
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(
      "Example:\n"
      "  raybundle eye-safety --edition 1993 --wavelength 850 --pulse 1000 --rate 100\n\n"
      "  class 1, IEC 60825-1 edition 1993, 850 nm, pulses of 1000 µs at 100 Hz, 7 mm aperture at 100 mm\n"
      "    a single pulse      7.854 mW during the pulse (C4 1.995, C6 1.000)\n"
      "    average power       4.417 mW during the pulse\n"
      "    train of pulses     0.785 mW during the pulse (C5 0.100, 10000 pulses in 100 s)\n"
      "  permissible through the aperture: 0.785 mW");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
