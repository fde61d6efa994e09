// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "input_flags.hpp"
#include "output_folder.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

struct DetectFlags {
  InputFlags input;
  std::string output = "observations.json";
  bool json = false;
};

std::string found_table(const DetectedImages& images) {
  const CalibrationProblem& problem = images.observations.problem;
  std::vector<std::vector<std::string>> rows{{"camera", "images", "boards found", "full", "corners"}};
  for (int c = 0; c < static_cast<int>(problem.cameras.size()); ++c) {
    int found = 0, full = 0;
    std::size_t corners = 0;
    for (const TargetView& view : problem.views) {
      if (view.camera != c) continue;
      ++found;
      full += view.observations.size() == problem.targets[view.target].points.size();
      corners += view.observations.size();
    }
    const auto files = std::ranges::count(images.files, c, &ImageFile::camera);
    rows.push_back({problem.cameras[c].name, fmt::format("{}", files), fmt::format("{}", found),
                    fmt::format("{}", full), fmt::format("{}", corners)});
  }
  return text_table(rows);
}

void run(const DetectFlags& flags) {
  require_writable_file(flags.output, "-o");
  const DetectedImages images = observe(flags.input, dataset_of(flags.input, false));
  require_views(images);
  const std::string text = text_from_observations(images.observations);
  write_file_whole(flags.output, text);
  for (const std::string& hint : images.hints) say_warning(hint);
  constexpr std::size_t kMostLines = 8;
  for (std::size_t i = 0; i < std::min(images.unused.size(), kMostLines); ++i) {
    say(images.unused[i].image + ": " + images.unused[i].reason);
  }
  if (images.unused.size() > kMostLines) say(fmt::format("and {} more", images.unused.size() - kMostLines));
  if (flags.json) {
    std::puts(text.c_str());
    return;
  }
  fmt::print("{}", found_table(images));
  const auto& models = images.observations.models;
  const bool modelled =
      std::ranges::all_of(models, [](const std::optional<ModelId>& model) { return model.has_value(); });
  fmt::print("\nwrote {} ({:.2f} s)\nnext  raybundle calibrate --observations {}{}\n", flags.output, images.seconds,
             shell_word(flags.output), modelled ? "" : " --model MODEL");
}

}  // namespace

void add_detect_verb(CLI::App& app) {
  auto flags = std::make_shared<DetectFlags>();
  CLI::App* verb = app.add_subcommand("detect", "images -> observations.json: where each corner of the board is");
  add_input_flags(*verb, flags->input);
  add_model_flags(*verb, flags->input);
  verb->add_option("-o,--output", flags->output, "file to write")->type_name("FILE")->capture_default_str();
  verb->add_flag("--json", flags->json, "print observations.json instead of the summary");
  verb->footer(
      "Example:\n"
      "  raybundle detect --target chessboard:9x6:25mm --camera left='left*.jpg' -o observations.json");
  verb->callback([flags] { run(*flags); });
}

}  // namespace raybundle::apps
