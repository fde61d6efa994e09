// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "april_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "board_dictionary.hpp"
#include "marker.hpp"
#include "marker_map.hpp"
#include "tag_corner.hpp"

namespace raybundle {
namespace {

constexpr double kMarkerWeight = 0.1;       // a contour's corner is good to about a pixel
constexpr double kReachPitches = 1.3;       // tags are predicted from known points up to this distance
constexpr double kFarthestShare = 0.15;     // of a tag, from the predicted place
constexpr double kMostMisread = 0.12;       // of a predicted tag's bits; codes differ in 30 % of theirs
constexpr double kMostMisreadAtLast = 0.2;  // when nothing better is found: a corner of the tag may be off
constexpr double kStrayShare = 0.06;        // of a tag: how far a corner may lie from where its neighbours predict it,
constexpr double kStray_px = 0.5;           // and a rest
constexpr double kSmallestWindow_px = 3.0;
constexpr double kFewestSquares = 0.25;  // of the first tags' corners that are saddles on a grid with corner squares

/// Corner `k` of a tag from its bottom-left, in tag sides, anticlockwise with y up.
constexpr std::array<std::array<double, 2>, 4> kCornerOf{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

/// Which corner (as counted in point ids) the first corner of an upright code is; they go on clockwise.
constexpr int kTopLeft = 3;

struct Grid {
  const cv::Mat& gray;
  AprilGrid board;
  cv::Ptr<cv::aruco::Dictionary> codes = tag_family_named(board.family);
  int turn = 0;                // quarter turns between the print's codes and the dictionary's
  bool corner_squares = true;  // saddles, otherwise plain tag corners

  double pitch_m() const { return board.tag_m * (1.0 + board.spacing); }
  int tags() const { return board.columns * board.rows; }
  Eigen::Vector2d place(int point_id) const {
    const int tag = point_id / 4;
    const Eigen::Vector2d base(board.column(tag), board.row_from_bottom(tag));
    const auto& corner = kCornerOf[point_id % 4];
    return pitch_m() * base + board.tag_m * Eigen::Vector2d(corner[0], corner[1]);
  }
  // Point ids in the order of Marker::corners.
  std::array<int, 4> corner_ids(int tag) const {
    std::array<int, 4> ids{};
    for (int k = 0; k < 4; ++k) ids[k] = 4 * tag + (kTopLeft - k + turn + 4) % 4;
    return ids;
  }
  MarkerLayout layout() const {
    MarkerLayout quads;
    for (int tag = 0; tag < tags(); ++tag) {
      Quad quad;
      const std::array<int, 4> ids = corner_ids(tag);
      for (int k = 0; k < 4; ++k) quad[k] = place(ids[k]);
      quads.push_back(quad);
    }
    return quads;
  }
};

// A corner near its predicted place. A tag's black corner meets the black square outside of it.
std::optional<Observation> refine_corner(const Grid& grid, int point_id, const LocalPrediction& prediction) {
  const int cells = grid.codes->markerSize + 2 * grid.board.border_bits;
  const Eigen::Vector2d side_x = prediction.pixel_from_board.col(0) * grid.board.tag_m;
  const Eigen::Vector2d side_y = prediction.pixel_from_board.col(1) * grid.board.tag_m;
  const double shorter = std::min(side_x.norm(), side_y.norm());
  if (shorter < 3.0 * kSmallestWindow_px) return std::nullopt;
  const bool along = point_id % 4 == 0 || point_id % 4 == 2;  // black on the diagonal (+, +)
  if (!grid.corner_squares) {
    const auto& corner = kCornerOf[point_id % 4];
    const Eigen::Vector2d inward_x = (corner[0] > 0.5 ? -1.0 : 1.0) * side_x;
    const Eigen::Vector2d inward_y = (corner[1] > 0.5 ? -1.0 : 1.0) * side_y;
    const auto found = refine_tag_corner(grid.gray, prediction.pixel, inward_x, inward_y, kFarthestShare * shorter);
    if (!found) return std::nullopt;
    return Observation{found->pixel, found->sigma_px, point_id};
  }
  const double border = static_cast<double>(grid.board.border_bits) / cells;
  const double share = std::max(std::min(border, grid.board.spacing), kSmallestWindow_px / shorter);
  const SaddleWindow sector{share * side_x, (along ? -share : share) * side_y};
  const auto saddle = find_saddle(grid.gray, prediction.pixel, sector, kFarthestShare * shorter);
  if (!saddle) return std::nullopt;
  return Observation{saddle->pixel, saddle->sigma_px, point_id};
}

struct Tag {
  std::vector<Observation> corners;
  Quad quad;  // refined corners, predicted ones where there is none
};

// Corner by corner, those next to what is known first: each one found steadies the prediction of the next.
std::optional<Tag> refine_tag(const Grid& grid, int index, MarkerMap map, double most_misread) {
  Tag tag;
  const std::array<int, 4> ids = grid.corner_ids(index);
  std::array<int, 4> order{0, 1, 2, 3};
  std::ranges::stable_sort(order, {}, [&](int k) { return map.distance(grid.place(ids[k])); });
  if (map.distance(grid.place(ids[order[0]])) > kReachPitches * grid.pitch_m()) return std::nullopt;
  for (const int k : order) {
    const auto prediction = map.predict(grid.place(ids[k]), kReachPitches * grid.pitch_m());
    if (!prediction) return std::nullopt;
    const auto corner = refine_corner(grid, ids[k], *prediction);
    if (corner) {
      tag.corners.push_back(*corner);
      map.add(grid.place(ids[k]), corner->pixel, 1.0);
    }
    tag.quad[k] = corner ? corner->pixel : prediction->pixel;
  }
  const std::size_t fewest = most_misread > kMostMisread ? 2 : 3;
  if (tag.corners.size() < fewest) return std::nullopt;
  const double misread =
      misread_bits(grid.gray, tag.quad, grid.codes, grid.board.first_tag + index, grid.board.border_bits);
  if (misread > most_misread) return std::nullopt;
  return tag;
}

// Drops corners that their neighbours do not bear out, the worst one first.
void drop_strays(const Grid& grid, std::map<int, Observation>& found) {
  while (found.size() > 8) {
    int worst = -1;
    double worst_share = 1.0;
    for (const auto& [id, corner] : found) {
      MarkerMap others;
      for (const auto& [other, at] : found) {
        const double distance = (grid.place(other) - grid.place(id)).norm();
        if (other != id && distance < 2.0 * grid.pitch_m()) others.add(grid.place(other), at.pixel, 1.0);
      }
      const auto prediction = others.predict(grid.place(id), grid.pitch_m());
      if (!prediction) continue;
      const double side = grid.board.tag_m * std::min(prediction->pixel_from_board.col(0).norm(),
                                                      prediction->pixel_from_board.col(1).norm());
      const double off = (corner.pixel - prediction->pixel).norm();
      const double share = off / (kStrayShare * side + kStray_px);
      if (share > worst_share) {
        worst_share = share;
        worst = id;
      }
    }
    if (worst < 0) return;
    found.erase(worst);
  }
}

struct Found {
  std::map<int, Observation> corners;  // by point id
  std::set<int> tags;
};

// Tag after tag, each predicted from what is known around it, until no more is found.
void add_tags(const Grid& grid, MarkerMap map, Found& found) {
  double most_misread = kMostMisread;
  for (bool progress = true; progress;) {
    std::vector<std::pair<int, Tag>> fresh;
    for (int index = 0; index < grid.tags(); ++index) {
      if (found.tags.contains(index)) continue;
      if (auto tag = refine_tag(grid, index, map, most_misread)) fresh.emplace_back(index, *tag);
    }
    for (const auto& [index, tag] : fresh) {
      found.tags.insert(index);
      for (const Observation& corner : tag.corners) {
        map.add(grid.place(corner.point_id), corner.pixel, 1.0);
        found.corners.emplace(corner.point_id, corner);
      }
    }
    progress = !fresh.empty() || most_misread == kMostMisread;
    if (fresh.empty()) most_misread = kMostMisreadAtLast;
  }
}

MarkerMap map_of(const Grid& grid, const std::map<int, Observation>& corners) {
  MarkerMap map;
  for (const auto& [id, corner] : corners) map.add(grid.place(id), corner.pixel, 1.0);
  return map;
}

// Corners of found tags that failed when little was known around them.
void add_missing_corners(const Grid& grid, Found& found) {
  const MarkerMap map = map_of(grid, found.corners);
  for (const int index : found.tags) {
    for (const int id : grid.corner_ids(index)) {
      if (found.corners.contains(id)) continue;
      const auto prediction = map.predict(grid.place(id), grid.pitch_m());
      if (!prediction) continue;
      if (const auto corner = refine_corner(grid, id, *prediction)) found.corners.emplace(id, *corner);
    }
  }
}

// From the tags that were read first to the whole board. A wrong corner leads its neighbours astray: after the strays
// are gone, what they hid is looked for again.
std::map<int, Observation> grow(const Grid& grid, const std::vector<Marker>& markers) {
  const MarkerLayout layout = grid.layout();
  MarkerMap seeds;
  for (const Marker& marker : markers) {
    for (int k = 0; k < 4; ++k) seeds.add(layout[marker.id][k], marker.corners[k], kMarkerWeight);
  }
  Found found;
  add_tags(grid, seeds, found);
  drop_strays(grid, found.corners);
  for (int round = 0; round < 2; ++round) {
    const std::size_t corners = found.corners.size(), tags = found.tags.size();
    add_missing_corners(grid, found);
    add_tags(grid, map_of(grid, found.corners), found);
    if (found.corners.size() == corners && found.tags.size() == tags) break;  // nor would another round
    drop_strays(grid, found.corners);
  }
  return found.corners;
}

// Whether the corners of tags meet black squares, as Kalibr prints them.
bool has_corner_squares(const Grid& grid, const std::vector<Marker>& markers) {
  const MarkerLayout layout = grid.layout();
  const double all = 4.0 * static_cast<double>(markers.size());
  int seen = 0;
  int saddles = 0;
  for (const Marker& marker : markers) {
    if (saddles >= kFewestSquares * all) return true;  // whatever the others show
    MarkerMap map;
    for (int k = 0; k < 4; ++k) map.add(layout[marker.id][k], marker.corners[k], 1.0);
    for (const int id : grid.corner_ids(marker.id)) {
      const auto prediction = map.predict(grid.place(id), grid.pitch_m());
      if (!prediction) continue;
      ++seen;
      if (refine_corner(grid, id, *prediction)) ++saddles;
    }
  }
  return saddles >= kFewestSquares * seen;
}

// The tags that stand as the board says, under the quarter turn that most agree with: printers of codes differ in it.
std::vector<Marker> choose_turn(Grid& grid, const std::vector<Marker>& markers) {
  std::vector<Marker> best;
  int best_turn = 0;
  for (int turn = 0; turn < 4; ++turn) {
    grid.turn = turn;
    std::vector<Marker> agreeing = consistent_markers(markers, grid.layout());
    if (agreeing.size() > best.size()) {
      best = std::move(agreeing);
      best_turn = turn;
    }
  }
  grid.turn = best_turn;
  return best;
}

std::vector<Marker> of_this_board(const std::vector<Marker>& markers, const AprilGrid& board) {
  std::vector<Marker> mine;
  for (Marker marker : markers) {
    marker.id -= board.first_tag;
    if (marker.id >= 0 && marker.id < board.columns * board.rows) mine.push_back(marker);
  }
  return mine;
}

// A tag's mirror image is no tag of the family.
std::size_t tags_in_mirror_image(const cv::Mat& gray, Grid grid) {
  cv::Mat flipped;
  cv::flip(gray, flipped, 1);
  const MarkerSearch search = find_markers(flipped, grid.codes, grid.board.border_bits);
  return choose_turn(grid, of_this_board(search.markers, grid.board)).size();
}

std::string hint_for(const cv::Mat& gray, const Grid& grid, const MarkerSearch& search) {
  const AprilGrid& board = grid.board;
  if (search.markers.size() + search.unread.size() >= 3) {
    const std::size_t mirrored = tags_in_mirror_image(gray, grid);
    if (mirrored >= 3) return fmt::format("{} tags are read in the image's mirror image: {}", mirrored, kMirrored);
  }
  if (search.markers.size() >= 3) {
    AprilGrid other_way = board;
    other_way.top_down = !board.top_down;
    Grid other{gray, other_way};
    if (choose_turn(other, of_this_board(search.markers, board)).size() >= 3) {
      return fmt::format("the tags' codes count from the {}: {}", board.top_down ? "bottom left" : "top left",
                         board.top_down ? "leave top_down out" : "try :top_down (in TOML top_down = true)");
    }
    return fmt::format(
        "{} tags of family {} seen, but too few that stand together as on a board of {} x {} tags from tag {}: take sharper "
        "or nearer images, or check columns, rows and first_tag",
        search.markers.size(), board.family, board.columns, board.rows, board.first_tag);
  }
  if (search.unread.size() < 3) return {};
  const int other = board.border_bits == 1 ? 2 : 1;
  const auto read = find_markers(gray, grid.codes, other).markers.size();
  if (read < 3) return {};
  return fmt::format("{} tags seen with a border of {} bit{}: try :{}bit (in TOML border_bits = {})", read, other,
                     other == 1 ? "" : "s", other, other);
}

}  // namespace

Detection detect_april_grid(const cv::Mat& gray, const AprilGrid& board) {
  Grid grid{gray, board};
  const MarkerSearch search = find_markers(gray, grid.codes, board.border_bits);
  const std::vector<Marker> mine = of_this_board(search.markers, board);
  const std::vector<Marker> markers = choose_turn(grid, mine);
  // A lone tag does not show by which quarter turn the print differs: its corners might be numbered from the wrong one.
  const bool lone = markers.empty() && mine.size() == 1;
  Detection detection;
  if (!markers.empty()) {
    grid.corner_squares = has_corner_squares(grid, markers);
    for (const auto& [id, corner] : grow(grid, markers)) detection.observations.push_back(corner);
  }
  if (detection.observations.empty()) {
    detection.hint = lone ? "only one tag of the board is seen, and it takes two to tell which way up they were printed"
                          : hint_for(gray, grid, search);
  }
  return detection;
}

std::vector<Observation> refine_predicted_april_grid(const cv::Mat& gray, const AprilGrid& board,
                                                     const std::vector<Observation>& predicted) {
  Grid grid{gray, board};
  MarkerMap map;
  for (const Observation& point : predicted) map.add(grid.place(point.point_id), point.pixel, 1.0);
  std::vector<Observation> accepted;
  for (int index = 0; index < grid.tags(); ++index) {
    std::optional<Tag> best;
    for (const bool squares : {true, false}) {
      grid.corner_squares = squares;
      for (int turn = 0; turn < 4 && !best; ++turn) {
        grid.turn = turn;
        best = refine_tag(grid, index, map, kMostMisreadAtLast);
      }
      if (best) break;
    }
    if (best) accepted.insert(accepted.end(), best->corners.begin(), best->corners.end());
  }
  std::ranges::sort(accepted, {}, &Observation::point_id);
  return accepted;
}

}  // namespace raybundle
