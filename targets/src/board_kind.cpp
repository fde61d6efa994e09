// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/board_kind.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "board_dictionary.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

constexpr bool kRequired = true;
constexpr bool kOptional = false;

template <typename Kind, typename Value>
BoardField field(Value Kind::*member, const char* name, FieldForm form, bool required, const char* help,
                 std::vector<std::string> choices = {}) {
  return {name,
          form,
          required,
          help,
          std::move(choices),
          [member](const Board& board) { return FieldValue(std::get<Kind>(board).*member); },
          [member](Board& board, const FieldValue& value) { std::get<Kind>(board).*member = std::get<Value>(value); }};
}

BoardKind chessboard() {
  using enum FieldForm;
  return {"chessboard",
          "chessboard of black and white squares",
          "chessboard:9x6:25mm",
          Chessboard{},
          {field(&Chessboard::columns, "columns", kCount, kRequired, "inner corners in a row"),
           field(&Chessboard::rows, "rows", kCount, kRequired, "inner corners in a column"),
           field(&Chessboard::square_m, "square_m", kLength, kRequired, "side of a square [m]")}};
}

BoardKind charuco() {
  using enum FieldForm;
  return {"charuco",
          "chessboard with ArUco markers in its white squares",
          "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000",
          Charuco{},
          {field(&Charuco::columns, "columns", kCount, kRequired, "squares in a row"),
           field(&Charuco::rows, "rows", kCount, kRequired, "squares in a column"),
           field(&Charuco::square_m, "square_m", kLength, kRequired, "side of a square [m]"),
           field(&Charuco::marker_m, "marker_m", kLength, kRequired, "side of a marker [m]"),
           field(&Charuco::dictionary, "dictionary", kChoice, kRequired, "OpenCV's name of the marker dictionary",
                 dictionary_names()),
           field(&Charuco::legacy, "legacy", kFlag, kOptional, "the layout before OpenCV 4.6 (even number of rows)"),
           field(&Charuco::inverted, "inverted", kFlag, kOptional, "white on black")}};
}

BoardKind aprilgrid() {
  using enum FieldForm;
  return {"aprilgrid",
          "grid of AprilTags or ArUco markers; by default as Kalibr prints it (36h11; also 25h9, 16h5, DICT_...)",
          "aprilgrid:6x6:88mm:0.3",
          AprilGrid{},
          {field(&AprilGrid::columns, "columns", kCount, kRequired, "tags in a row"),
           field(&AprilGrid::rows, "rows", kCount, kRequired, "tags in a column"),
           field(&AprilGrid::tag_m, "tag_m", kLength, kRequired, "side of a tag, outer edge of its black border [m]"),
           field(&AprilGrid::spacing, "spacing", kRatio, kRequired, "gap between tags over the tag's side"),
           field(&AprilGrid::family, "family", kChoice, kOptional, "tag family, 36h11 unless said", tag_family_names()),
           field(&AprilGrid::border_bits, "border_bits", kBits, kOptional,
                 "width of the black border: 2 as Kalibr's, which holds unless said, or 1 as AprilTag's own"),
           field(&AprilGrid::first_tag, "first_tag", kNumber, kOptional, "the lowest code, 0 unless said"),
           field(&AprilGrid::top_down, "top_down", kFlag, kOptional,
                 "codes count from the top left, as OpenCV's GridBoard, not from the bottom left")}};
}

BoardKind circles() {
  using enum FieldForm;
  return {"circles",
          "grid of black discs",
          "circles:7x7:20mm",
          Circles{},
          {field(&Circles::columns, "columns", kCount, kRequired, "circles in a row"),
           field(&Circles::rows, "rows", kCount, kRequired, "circles in a column"),
           field(&Circles::spacing_m, "spacing_m", kLength, kRequired, "between neighbouring centres [m]")}};
}

BoardKind asymmetric_circles() {
  using enum FieldForm;
  return {"asymmetric_circles",
          "grid of black discs, odd rows shifted by half a step (OpenCV's)",
          "asymmetric_circles:4x11:20mm",
          AsymmetricCircles{},
          {field(&AsymmetricCircles::columns, "columns", kCount, kRequired, "circles in a row"),
           field(&AsymmetricCircles::rows, "rows", kCount, kRequired, "rows of circles"),
           field(&AsymmetricCircles::spacing_m, "spacing_m", kLength, kRequired,
                 "half the distance between neighbours in a row [m]"),
           field(&AsymmetricCircles::row_step_m, "row_step_m", kLength, kOptional,
                 "between neighbouring rows; without it as spacing_m [m]"),
           field(&AsymmetricCircles::first_row_shifted, "first_row_shifted", kFlag, kOptional,
                 "the first row is shifted, and not the second")}};
}

BoardKind points() {
  return {"points",
          "any rigid set of points, for observations that others made",
          "points:board.csv",
          PointSet{},
          {field(&PointSet::file, "file", FieldForm::kFile, kRequired, "CSV with columns point_id,x,y,z [m]")}};
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string required_part(const BoardField& field) {
  return upper(field.word_name()) + (field.form == FieldForm::kFile ? ".csv" : "");
}

std::string optional_part(const BoardField& field) {
  if (field.form == FieldForm::kFlag) return "[:" + field.name + "]";
  if (field.form == FieldForm::kBits) return "[:1bit|2bit]";
  if (field.form != FieldForm::kChoice) return "[:" + field.word_name() + "=" + upper(field.word_name()) + "]";
  return "[:" + upper(field.word_name()) + "]";
}

}  // namespace

std::string BoardField::word_name() const {
  const bool in_metres = form == FieldForm::kLength && name.ends_with("_m");
  return in_metres ? name.substr(0, name.size() - 2) : name;
}

std::string BoardKind::form() const {
  std::string text = name;
  for (size_t i = 0; i < fields.size(); ++i) {
    const bool second_count = i > 0 && fields[i].form == FieldForm::kCount && fields[i - 1].form == FieldForm::kCount;
    text += fields[i].required ? (second_count ? "x" : ":") + required_part(fields[i]) : optional_part(fields[i]);
  }
  return text;
}

const std::vector<BoardKind>& board_kinds() {
  static const std::vector<BoardKind> kinds{chessboard(),         charuco(), aprilgrid(), circles(),
                                            asymmetric_circles(), points()};
  return kinds;
}

const BoardKind& board_kind_of(const Board& board) { return board_kinds().at(board.index()); }

const BoardKind& board_kind_named(const std::string& name) {
  std::vector<std::string> names;
  for (const BoardKind& kind : board_kinds()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  throw Error(ErrorKind::kBadInput, "there is no kind of board \"" + name + "\"." + did_you_mean(name, names));
}

}  // namespace raybundle
