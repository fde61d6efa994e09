// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "page_text.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/targets/board_file.hpp"
#include "raybundle/targets/board_kind.hpp"
#include "raybundle/targets/draw.hpp"
#include "terminal.hpp"
#include "verbs.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;

struct TargetFlags {
  std::string board;
  std::string output;
  double margin_mm = 10.0;
  DrawOptions draw;
  bool json = false;
};

// A data set that someone wrote by hand is never overwritten by the board's TOML of the same name.
void require_own_or_absent(const fs::path& toml) {
  std::ifstream file(toml);
  std::string first;
  if (!std::getline(file, first) || first.starts_with("# raybundle target ")) return;
  throw Error(
      ErrorKind::kBadInput,
      fmt::format("{} exists and was not written by `raybundle target`; draw to another name with -o", toml.string()));
}

std::string scale_in_words(const Drawing& drawing, const TargetFlags& flags) {
  if (drawing.paper.empty()) {
    return fmt::format("{} px a square, for a screen: measure a square on it and correct the TOML",
                       flags.draw.square_px);
  }
  const bool fit = drawing.paper == "fit";
  const char* turned = drawing.width_m > drawing.height_m ? "landscape" : "portrait";
  return fmt::format("{} {:.0f} x {:.0f} mm: print at 100 %, then check that the ruler is 100 mm long",
                     fit ? "a page of" : fmt::format("{} {}", drawing.paper, turned), 1e3 * drawing.width_m,
                     1e3 * drawing.height_m);
}

// A flag without effect would be believed to have had one.
void refuse_idle_flags(const CLI::App& verb, const TargetFlags& flags) {
  const bool is_png = format_of_path(flags.output) == DrawingFormat::kPng,
             in_true_scale = !is_png || flags.draw.dpi > 0;
  const auto refuse = [&](const char* flag, const std::string& why) {
    if (verb.count(flag) > 0) throw Error(ErrorKind::kBadInput, fmt::format("{} {}; leave it out", flag, why));
  };
  if (!is_png) refuse("--dpi", "is for .png; .pdf and .svg have no pixels");
  if (in_true_scale) refuse("--square-px", "is for a .png without --dpi; all else is drawn in true scale");
  for (const char* flag : {"--paper", "--margin"}) {
    if (!in_true_scale) refuse(flag, "is for a page; a .png without --dpi has none");
  }
}

void run(const TargetFlags& flags) {
  const Board board = board_from_word_or_toml(flags.board);
  const DrawingFormat format = format_of_path(flags.output);
  DrawOptions options = flags.draw;
  options.margin_m = flags.margin_mm / 1000.0;
  const fs::path toml = fs::path(flags.output).replace_extension(".toml");
  std::error_code ignored;
  const bool is_input = fs::equivalent(flags.board, toml, ignored);
  if (!is_input) require_own_or_absent(toml);
  const Drawing drawing = draw(board, format, options);
  write_file_whole(flags.output, drawing.bytes);
  if (!is_input) write_board_toml(board, toml);

  if (flags.json) {
    const nlohmann::ordered_json result{{"target", word_of(board)},   {"drawing", flags.output},
                                        {"toml", toml.string()},      {"paper", drawing.paper},
                                        {"width_m", drawing.width_m}, {"height_m", drawing.height_m}};
    fmt::print("{}\n", text_of_json(result, 2));
    return;
  }
  fmt::print("{}\n  {}\n  {}\n  {}\nnext  raybundle calibrate --target {} --camera NAME='*.jpg' --model MODEL -o out\n",
             word_of(board), flags.output, toml.string(), scale_in_words(drawing, flags), shell_word(word_of(board)));
}

std::string footer() {
  std::string text = "Boards in one word (lengths in mm, cm, m or in):\n";
  for (const BoardKind& kind : board_kinds()) {
    text += fmt::format("  {}\n      {}; {}\n", kind.example, kind.help, kind.form());
  }
  return text +
         "\nExample:\n"
         "  $ raybundle target chessboard:9x6:25mm -o board.pdf\n"
         "  chessboard:9x6:25mm\n"
         "    board.pdf\n"
         "    board.toml\n"
         "    A4 landscape 297 x 210 mm: print at 100 %, then check that the ruler is 100 mm long\n"
         "  next  raybundle calibrate --target chessboard:9x6:25mm --camera NAME='*.jpg' --model MODEL -o out";
}

std::string paper_help() {
  std::string names;
  for (const std::string& name : paper_names()) names += (names.empty() ? "" : ", ") + name;
  return names + "; without it the smallest of A4 to A0 that holds the board";
}

}  // namespace

void add_target_verb(CLI::App& app) {
  auto flags = std::make_shared<TargetFlags>();
  CLI::App* verb = app.add_subcommand("target", "draw a board in true scale, with its TOML beside it");
  verb->add_option("board", flags->board, "the board in one word, or its .toml")->required();
  verb->add_option("-o,--output", flags->output, "file to draw: .pdf or .svg to print, .png for a screen")->required();
  verb->add_option("--paper", flags->draw.paper, paper_help());
  verb->add_option("--margin", flags->margin_mm, "white on each side of the page [mm]")->capture_default_str();
  verb->add_option("--square-px", flags->draw.square_px, "of a .png: pixels of a square, tag or step [px]")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  verb->add_option("--dpi", flags->draw.dpi, "of a .png: true scale with ruler at that many pixels per inch")
      ->check(CLI::Range(1.0, 10000.0));
  verb->add_flag("--json", flags->json, "print the result as JSON");
  verb->footer(footer());
  verb->callback([flags, verb] {
    refuse_idle_flags(*verb, *flags);
    run(*flags);
  });
}

}  // namespace raybundle::apps
