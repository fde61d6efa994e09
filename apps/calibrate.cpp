// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <set>

#include "calibrate_job.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct CalibrateFlags {
  CalibrateJob job;
  std::vector<std::string> fix, free, prior;
};

void add_rules(ParameterRule::Kind kind, const std::vector<std::string>& flags, std::vector<ParameterRule>& rules) {
  for (const std::string& flag : flags) rules.push_back(rule_from_flag(kind, flag));
}

// What was asked for by flags, for the provenance. Where results go, in which form, and how fast they are there is left
// out: equal inputs give equal bytes.
std::vector<std::pair<std::string, std::string>> flags_given_to(const CLI::App& verb) {
  static const std::set<std::string> kWithoutEffect{"--output", "--json", "--threads", "--no-cache"};
  std::vector<std::pair<std::string, std::string>> given;
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || kWithoutEffect.contains(name)) continue;
    if (option->get_items_expected_max() == 0) {
      const bool negated = !option->get_fnames().empty();  // --no-...
      given.emplace_back(name, option->as<bool>() != negated ? "true" : "false");
      continue;
    }
    for (const std::string& value : option->results()) given.emplace_back(name, value);
  }
  return given;
}

void declare(CLI::App& verb, CalibrateFlags& flags) {
  CalibrateJob& job = flags.job;
  add_input_flags(verb, job.input);
  add_model_flags(verb, job.input);
  verb.add_option("-o,--output", job.output, "folder for calibration.json, report.json and report.html")
      ->type_name("DIR")
      ->capture_default_str();
  verb.add_option("--start", job.start, "calibration.json to start from")->type_name("FILE");
  verb.add_option("--fix", flags.fix, "keep a parameter, as 'left.cx=640', '*.k3=0' or '*.intrinsics' with --start")
      ->type_name("NAME[=VALUE]")
      ->allow_extra_args(false);
  verb.add_option("--free", flags.free, "free a parameter again")->type_name("NAME")->allow_extra_args(false);
  verb.add_option("--prior", flags.prior,
                  "give a parameter a prior, as left.fx=500:5, its sigma in the parameter's own unit")
      ->type_name("NAME=MEAN:SIGMA")
      ->allow_extra_args(false);
  verb.add_flag("!--no-predicted-corners", job.predict_corners, "leave out corners that only a first solve predicts");
  add_survey_flags(verb, false, job.survey);
  add_gate_flags(verb, job.gates);
  verb.add_flag("--cross-validate", job.checks.cross_validate,
                "solve the odd and the even frames apart and compare them; a model that does not fit shows");
  verb.add_flag("--second-opinion", job.checks.second_opinion, "let mrcal solve the same corners, and compare");
  verb.add_flag("--json", job.json, "print report.json instead of the summary");
  CalibrateOptions::for_each_option(
      job.options, [&]<typename T>(const char* name, const char* unit, const char* help, T& value) {
        std::string flag = "--" + std::string(name);
        std::ranges::replace(flag, '_', '-');
        if (flag == "--threads") return;  // detection has the same flag
        const std::string text = *unit == '\0' ? help : fmt::format("{} [{}]", help, unit);
        verb.add_option(flag, value, text)->capture_default_str()->each([&job, name](const std::string&) {
          job.options_given.insert(name);
        });
      });
}

}  // namespace

void add_calibrate_verb(CLI::App& app) {
  auto flags = std::make_shared<CalibrateFlags>();
  CLI::App* verb = app.add_subcommand("calibrate", "images or corners -> calibration.json, report.json, report.html");
  declare(*verb, *flags);
  verb->footer(
      "Example (the stereo pairs of Debian's package opencv-doc):\n"
      "  raybundle calibrate --target chessboard:9x6:25mm --camera left='left*.jpg' --camera right='right*.jpg' "
      "--model brown_conrady -o out\n"
      "The same from a file: raybundle calibrate dataset.toml -o out\n"
      "With a demand:        ... --require 'depth 20 mm at 1 m' --require 'projection 0.2 px over 60 deg'");
  verb->callback([flags, verb] {
    CalibrateJob& job = flags->job;
    add_rules(ParameterRule::Kind::kFixed, flags->fix, job.rules);
    add_rules(ParameterRule::Kind::kFree, flags->free, job.rules);
    add_rules(ParameterRule::Kind::kPrior, flags->prior, job.rules);
    job.command = "raybundle calibrate";
    job.flags_given = flags_given_to(*verb);
    run_calibration(job);
  });
}

}  // namespace raybundle::apps
