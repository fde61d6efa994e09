// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "simulated_board.hpp"

#include <filesystem>

#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_file.hpp"
#include "raybundle/targets/board_picture.hpp"

namespace raybundle::apps {
namespace {

constexpr std::string_view kRandom = "random:";

// The print of a board in the axes of its target.
class PrintMaker {
 public:
  explicit PrintMaker(const BoardPicture& picture) : picture_(picture) {}

  BoardPrint print() const {
    BoardPrint print;
    print.sheet = box({0, 0}, picture_.size);
    if (picture_.inverted) print.ground = print.sheet;
    for (const PictureRectangle& r : picture_.rectangles) print.boxes.push_back(box(r.corner, r.corner + r.size));
    for (const PictureDisc& disc : picture_.discs) print.discs.push_back({in_target(disc.centre), disc.radius});
    // The picture's y points down: axes that turn as it does look into the board.
    const double turn =
        picture_.x_direction.x() * picture_.y_direction.y() - picture_.x_direction.y() * picture_.y_direction.x();
    print.front = turn > 0 ? -1.0 : 1.0;
    return print;
  }

 private:
  Eigen::Vector2d in_target(const Eigen::Vector2d& place) const {
    const Eigen::Vector2d from_origin = place - picture_.origin;
    return {from_origin.dot(picture_.x_direction), from_origin.dot(picture_.y_direction)};
  }

  BoardPrint::Box box(const Eigen::Vector2d& corner, const Eigen::Vector2d& opposite) const {
    const Eigen::Vector2d a = in_target(corner), b = in_target(opposite);
    return {a.cwiseMin(b), a.cwiseMax(b)};
  }

  const BoardPicture& picture_;
};

SimulatedBoard simulated(const Board& board) {
  SimulatedBoard made;
  made.target = target_of(board);
  made.target.name = "board";
  if (!std::holds_alternative<PointSet>(board)) {
    made.print = PrintMaker(picture_of(board)).print();
    return made;
  }
  BoardPrint::Box& sheet = made.print.sheet;  // points without a print: observations can be made of them, not images
  sheet = {made.target.points[0].x_in_target.head<2>(), made.target.points[0].x_in_target.head<2>()};
  for (const TargetPoint& point : made.target.points) {
    sheet.low = sheet.low.cwiseMin(point.x_in_target.head<2>());
    sheet.high = sheet.high.cwiseMax(point.x_in_target.head<2>());
  }
  return made;
}

BoardedRig random_rig_of(const std::string& word) {
  const std::string seed = word.substr(kRandom.size());
  if (seed.empty() || seed.size() > 18 || seed.find_first_not_of("0123456789") != std::string::npos) {
    throw Error(ErrorKind::kBadInput, "'" + word + "' has no seed; write a whole number, as in random:7");
  }
  BoardedRig boarded{random_rig(std::stoull(seed)), Chessboard{}};
  const std::vector<TargetPoint>& points = boarded.rig.board.target.points;
  boarded.board = Chessboard{9, 6, points[1].x_in_target.x() - points[0].x_in_target.x()};
  return boarded;
}

}  // namespace

BoardedRig rig_of(const std::string& path_or_word) {
  if (path_or_word.starts_with(kRandom)) return random_rig_of(path_or_word);
  BoardedRig boarded;
  const std::filesystem::path folder = std::filesystem::path(path_or_word).parent_path();
  boarded.rig = read_rig(path_or_word, [&](const std::string& text, const std::string& file) {
    boarded.board = board_from_toml_text(text, file, folder);
    return simulated(boarded.board);
  });
  return boarded;
}

}  // namespace raybundle::apps
