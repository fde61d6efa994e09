// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "draw_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

struct Paper {
  const char* name;
  double short_m;
  double long_m;
  bool automatic;  // may be chosen when none is named
};

constexpr std::array<Paper, 8> kPapers{{{"A4", 0.210, 0.297, true},
                                        {"A3", 0.297, 0.420, true},
                                        {"A2", 0.420, 0.594, true},
                                        {"A1", 0.594, 0.841, true},
                                        {"A0", 0.841, 1.189, true},
                                        {"letter", 0.2159, 0.2794, false},
                                        {"legal", 0.2159, 0.3556, false},
                                        {"tabloid", 0.2794, 0.4318, false}}};
constexpr const char* kFit = "fit";

// What margins and strip take of a page.
Eigen::Vector2d taken(double margin_m) { return {2 * margin_m, 2 * margin_m + kStripHeight}; }

// How much larger the picture could be on a page of that size.
double scale_on(const Eigen::Vector2d& page, const Eigen::Vector2d& picture, double margin_m) {
  return ((page - taken(margin_m)).array() / picture.array()).minCoeff();
}

Page placed(const std::string& paper, const Eigen::Vector2d& size, const Eigen::Vector2d& picture, double margin_m) {
  const Eigen::Vector2d free = size - taken(margin_m) - picture;
  const Eigen::Vector2d board = Eigen::Vector2d::Constant(margin_m) + 0.5 * free;
  const double strip_x = std::min(board.x(), size.x() - margin_m - kRulerLength);
  return {paper, size, board, Eigen::Vector2d(strip_x, board.y() + picture.y() + kStripGap)};
}

// The way up on which the picture has more room; portrait when that is the same.
Eigen::Vector2d turned(const Paper& paper, const Eigen::Vector2d& picture, double margin_m) {
  const Eigen::Vector2d portrait(paper.short_m, paper.long_m);
  const Eigen::Vector2d landscape(paper.long_m, paper.short_m);
  return scale_on(landscape, picture, margin_m) > scale_on(portrait, picture, margin_m) ? landscape : portrait;
}

// The same board with all lengths scaled, to whole tenths of a millimetre so that it can be typed.
Board scaled(const Board& board, double scale) {
  Board smaller = board;
  for (const BoardField& field : board_kind_of(board).fields) {
    if (field.form != FieldForm::kLength) continue;
    const double length_m = std::get<double>(field.get(board)) * scale;
    field.set(smaller, std::floor(length_m * 1e4) / 1e4);
  }
  return smaller;
}

std::string length_name(const BoardKind& kind) {
  const auto field = std::ranges::find(kind.fields, FieldForm::kLength, &BoardField::form);
  return field->word_name();
}

[[noreturn]] void does_not_fit(const Board& board, const BoardPicture& picture, const Paper& paper, double scale) {
  const std::string needs = fmt::format("{} prints {:.1f} x {:.1f} mm and does not fit {}", word_of(board),
                                        1e3 * picture.size.x(), 1e3 * picture.size.y(), paper.name);
  const BoardKind& kind = board_kind_of(board);
  const Board smaller = scaled(board, std::max(scale, 0.0));
  const auto length = std::ranges::find(kind.fields, FieldForm::kLength, &BoardField::form);
  if (std::get<double>(length->get(smaller)) <= 0.0) {
    throw Error(ErrorKind::kBadInput,
                needs + ", nor does any of its kind; make the margin smaller or take --paper fit");
  }
  throw Error(ErrorKind::kBadInput,
              fmt::format("{}; the biggest {} that does is {:.1f} mm: {}; or take larger paper, or --paper fit", needs,
                          length_name(kind), 1e3 * std::get<double>(length->get(smaller)), word_of(smaller)));
}

}  // namespace

std::vector<std::string> paper_names() {
  std::vector<std::string> names;
  for (const Paper& paper : kPapers) names.emplace_back(paper.name);
  names.emplace_back(kFit);
  return names;
}

Page page_of(const Board& board, const BoardPicture& picture, const DrawOptions& options) {
  for (const Paper& paper : kPapers) {
    if (options.paper.empty() ? !paper.automatic : options.paper != paper.name) continue;
    const Eigen::Vector2d size = turned(paper, picture.size, options.margin_m);
    const double scale = scale_on(size, picture.size, options.margin_m);
    if (scale >= 1.0) return placed(paper.name, size, picture.size, options.margin_m);
    if (!options.paper.empty()) does_not_fit(board, picture, paper, scale);
  }
  if (!options.paper.empty() && options.paper != kFit) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("there is no paper \"{}\".{}", options.paper, did_you_mean(options.paper, paper_names())));
  }
  const Eigen::Vector2d needed(std::max(picture.size.x(), kRulerLength), picture.size.y());
  return placed(kFit, needed + taken(options.margin_m), picture.size, options.margin_m);
}

Page bare_page_of(const BoardPicture& picture, double margin_m) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(margin_m);
  return {"", picture.size + 2 * margin, margin, std::nullopt};
}

}  // namespace raybundle
