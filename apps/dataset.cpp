// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board_toml.hpp"
#include "table_reader.hpp"

namespace raybundle::apps {
namespace {

DatasetCamera camera_from(const toml::table& table, const std::string& file) {
  TableReader reader(table, "[[camera]]", file);
  DatasetCamera camera{reader.text("name"), reader.texts("images"), reader.text("model"), {}};
  if (table.contains("laser_on")) camera.laser_on = reader.texts("laser_on");
  reader.refuse_unknown_keys();
  model_from_name(camera.model, fmt::format("{}:{}", file, table.source().begin.line));
  return camera;
}

LaserGrid grid_from(const std::string& word, const TableReader& reader) {
  constexpr int kMost = 64;
  const auto [columns, rows] = two_numbers_from<int>(word, 'x').value_or(std::array{0, 0});
  if (columns < 1 || rows < 1 || columns > kMost || rows > kMost) {
    reader.fail(nullptr,
                fmt::format("[laser].grid is '{}', but must be COLUMNSxROWS of beams up to 64x64, as \"11x11\"", word));
  }
  return {rows, columns};
}

// Two numbers in brackets.
Eigen::Vector2d pair_from(const toml::node& node, const TableReader& reader, const char* what) {
  const toml::array* array = node.as_array();
  const bool good = array != nullptr && array->size() == 2 && (*array)[0].is_number() && (*array)[1].is_number();
  if (!good) reader.fail(&node, fmt::format("{} must be two numbers in brackets", what));
  return {*(*array)[0].value<double>(), *(*array)[1].value<double>()};
}

int beam_from(const toml::node& node, const LaserGrid& grid, const TableReader& reader) {
  const Eigen::Vector2d label = pair_from(node, reader, "a beam, [row, column],");
  const bool on_grid = label.x() >= 0 && label.x() < grid.rows && label.y() >= 0 && label.y() < grid.columns;
  const int row = on_grid ? static_cast<int>(label.x()) : 0, column = on_grid ? static_cast<int>(label.y()) : 0;
  if (!on_grid || row != label.x() || column != label.y()) {
    reader.fail(&node, fmt::format("there is no beam in row {} and column {} of {} rows and {} columns, counted from 0",
                                   label.x(), label.y(), grid.rows, grid.columns));
  }
  return grid.index(row, column);
}

DatasetAnchor anchor_from(const toml::table& table, const LaserGrid& grid, const std::string& file) {
  TableReader reader(table, "[laser].anchor", file);
  DatasetAnchor anchor;
  anchor.camera = reader.text("camera");
  anchor.frame = reader.text("frame");
  const toml::node* pixel = reader.get("pixel");
  const toml::node* beam = reader.get("beam");
  if (pixel == nullptr || beam == nullptr) {
    reader.fail(nullptr, "[laser].anchor needs pixel = [u, v] and beam = [row, column]");
  }
  anchor.pixel = pair_from(*pixel, reader, "[laser].anchor.pixel");
  const int index = beam_from(*beam, grid, reader);
  anchor.row = grid.row(index);
  anchor.column = grid.column(index);
  reader.refuse_unknown_keys();
  return anchor;
}

DatasetLaser laser_from(const toml::table& table, const std::string& file) {
  TableReader reader(table, "[laser]", file);
  DatasetLaser laser{grid_from(reader.text("grid"), reader), {}, {}, {}};
  if (const toml::node* brightest = reader.get("brightest"))
    laser.brightest = beam_from(*brightest, laser.grid, reader);
  if (const toml::node* missing = reader.get("missing")) {
    if (!missing->is_array()) reader.fail(missing, "[laser].missing must be a list of beams, as [[0, 0], [0, 10]]");
    for (const toml::node& beam : *missing->as_array()) laser.missing.push_back(beam_from(beam, laser.grid, reader));
  }
  if (const toml::node* anchor = reader.get("anchor")) {
    if (!anchor->is_table()) reader.fail(anchor, "[laser].anchor must be a table");
    laser.anchor = anchor_from(*anchor->as_table(), laser.grid, file);
  }
  reader.refuse_unknown_keys();
  return laser;
}

SurveyInput survey_from(const toml::table& table, const std::string& file) {
  TableReader reader(table, "[survey]", file);
  const std::filesystem::path folder = std::filesystem::path(file).parent_path();
  SurveyInput survey;
  survey.landmarks = (folder / reader.text("landmarks")).generic_string();
  survey.sightings = (folder / reader.text("sightings")).generic_string();
  survey.height = reader.value<std::string>("height", "a text in quotes").value_or("");
  survey.sigma_px = reader.value<double>("sigma_px", "a number").value_or(survey.sigma_px);
  if (!(survey.sigma_px > 0) || !std::isfinite(survey.sigma_px)) {
    reader.fail(nullptr, "[survey].sigma_px must be positive and finite");
  }
  if (const toml::node* origin = reader.get("origin")) {
    const toml::array* numbers = origin->as_array();
    for (std::size_t i = 0; numbers != nullptr && i < numbers->size(); ++i) {
      survey.origin.push_back((*numbers)[i].value<double>().value_or(std::nan("")));
    }
    if (survey.origin.size() != 3 || !std::ranges::all_of(survey.origin, [](double x) { return std::isfinite(x); })) {
      reader.fail(origin, "[survey].origin must be [latitude, longitude, height] in degrees and metres");
    }
  }
  reader.refuse_unknown_keys();
  return survey;
}

DatasetBoard board_from(const toml::table& table, const std::string& file, std::size_t index) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  const std::string fallback = index == 0 ? "board" : fmt::format("board{}", index + 1);
  TableReader reader(table, "[target]", file);
  return {reader.value<std::string>("name", "a text in quotes").value_or(fallback),
          board_from_toml(table, file, folder, {"name"})};
}

ParameterRule rule_from(const toml::table& table, const std::string& file) {
  TableReader reader(table, "[[parameter]]", file);
  ParameterRule rule;
  rule.pattern = reader.text("name");
  const std::optional<double> fixed = reader.value<double>("fixed", "a number");
  const std::optional<double> prior = reader.value<double>("prior", "a number");
  const std::optional<double> sigma = reader.value<double>("sigma", "a number");
  const std::optional<bool> free = reader.value<bool>("free", "true or false");
  reader.refuse_unknown_keys();
  if (fixed.has_value() + prior.has_value() + free.value_or(false) != 1 || free == false ||
      prior.has_value() != sigma.has_value()) {
    reader.fail(nullptr, "[[parameter]] needs one of: fixed = VALUE; prior = MEAN with sigma = SIGMA; free = true");
  }
  rule.kind = prior ? ParameterRule::Kind::kPrior : fixed ? ParameterRule::Kind::kFixed : ParameterRule::Kind::kFree;
  rule.value = fixed ? fixed : prior;
  rule.sigma = sigma.value_or(0.0);
  return rule;
}

void read_options(const toml::table& table, const std::string& file, CalibrateOptions& options) {
  TableReader reader(table, "[calibrate]", file);
  CalibrateOptions::for_each_option(options, [&]<typename T>(const char* name, const char*, const char*, T& value) {
    constexpr const char* kWhat = std::is_same_v<T, bool> ? "true or false" : "a number";
    if (const std::optional<T> found = reader.value<T>(name, kWhat)) value = *found;
  });
  reader.refuse_unknown_keys();
  check(options, fmt::format("{}:{}", file, table.source().begin.line));
}

double number(const std::string& text, const std::string& flag) {
  const std::optional<double> value = number_from<double>(text);
  if (!value || !std::isfinite(*value)) {
    throw Error(ErrorKind::kBadInput, fmt::format("'{}' is not a number in '{}'", text, flag));
  }
  return *value;
}

// What to do about the mistakes in TOML that people make most.
std::string toml_hint(const std::string& text, std::string_view problem) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  const auto says = [&](std::string_view part) { return problem.find(part) != std::string_view::npos; };
  if (first != std::string::npos && text[first] == '{') {
    return "; this is JSON, not a dataset.toml: corners found before are given with --observations";
  }
  if (says("escape sequence")) return "; write / for \\ in paths";
  if (says("determine value type")) return "; text stands in quotes, as in kind = \"chessboard\"";
  if (says("redefine existing table")) return "; of several write each in double brackets, as [[camera]]";
  return "";
}

}  // namespace

ModelId model_from_name(const std::string& name, const std::string& where) {
  if (const std::optional<ModelId> model = model_named(name)) return *model;
  std::vector<std::string> names;
  for (std::string_view known : model_names()) names.emplace_back(known);
  throw Error(ErrorKind::kBadInput, fmt::format("there is no camera model '{}'.{}", name, did_you_mean(name, names)),
              where);
}

Dataset dataset_from_text(const std::string& text, const std::string& path) {
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw Error(ErrorKind::kBadInput, std::string(error.description()) + toml_hint(text, error.description()),
                fmt::format("{}:{}", path, error.source().begin.line));
  }
  Dataset dataset;
  dataset.folder = std::filesystem::path(path).parent_path().string();
  TableReader reader(root, "the file", path);
  for (const toml::table* table : tables(reader, "target")) {
    const DatasetBoard board = board_from(*table, path, dataset.boards.size());
    if (std::ranges::find(dataset.boards, board.name, &DatasetBoard::name) != dataset.boards.end()) {
      reader.fail(table, fmt::format("two [[target]] are called '{}'; rename one", board.name));
    }
    dataset.boards.push_back(board);
  }
  for (const toml::table* table : tables(reader, "camera")) dataset.cameras.push_back(camera_from(*table, path));
  const std::vector<const toml::table*> lasers = tables(reader, "laser");
  if (lasers.size() > 1) reader.fail(lasers[1], "there is a second [laser]; a rig has one");
  for (const toml::table* table : lasers) dataset.laser = laser_from(*table, path);
  const std::vector<const toml::table*> surveys = tables(reader, "survey");
  if (surveys.size() > 1) reader.fail(surveys[1], "there is a second [survey]; put all landmarks into one");
  for (const toml::table* table : surveys) dataset.survey = survey_from(*table, path);
  for (const toml::table* table : tables(reader, "parameter")) dataset.rules.push_back(rule_from(*table, path));
  for (const toml::table* table : tables(reader, "calibrate")) read_options(*table, path, dataset.options);
  reader.refuse_unknown_keys();
  if (dataset.boards.empty()) reader.fail(nullptr, "there is no [target] section; say which board was used");
  if (dataset.cameras.empty()) reader.fail(nullptr, "there is no [[camera]] section; say where the images are");
  const bool any_on = std::ranges::any_of(dataset.cameras, [](const DatasetCamera& c) { return !c.laser_on.empty(); });
  if (dataset.laser.has_value() != any_on) {
    reader.fail(nullptr,
                any_on ? "there is laser_on, but no [laser] section; add one with its grid, as grid = \"11x11\""
                       : "there is a [laser], but no camera has laser_on; say where the images with the laser on are");
  }
  return dataset;
}

Dataset read_dataset(const std::string& path) { return dataset_from_text(text_of_file(path), path); }

DatasetCamera camera_from_flag(const std::string& flag, const std::string& model) {
  const std::size_t equals = flag.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == flag.size()) {
    throw Error(ErrorKind::kBadInput, fmt::format("--camera '{}' must be NAME='IMAGES', as in left='left*.jpg'", flag));
  }
  return {flag.substr(0, equals), {flag.substr(equals + 1)}, model, {}};
}

DatasetAnchor anchor_from_flag(const std::string& flag) {
  const std::size_t slash = flag.find('/'), colon = flag.rfind(':'), equals = flag.find('=', colon);
  const bool parts = slash != std::string::npos && colon != std::string::npos && equals != std::string::npos &&
                     slash > 0 && slash + 1 < colon;
  const std::string_view text = flag;
  const auto pixel = parts ? two_numbers_from<double>(text.substr(colon + 1, equals - colon - 1), ',') : std::nullopt;
  const auto label = parts ? two_numbers_from<int>(text.substr(equals + 1), ',') : std::nullopt;
  if (!pixel || !label || !std::isfinite((*pixel)[0]) || !std::isfinite((*pixel)[1])) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("--anchor '{}' must be CAMERA/FRAME:U,V=ROW,COLUMN, as in left/12:320.5,240=5,5", flag));
  }
  return {flag.substr(0, slash),
          flag.substr(slash + 1, colon - slash - 1),
          {(*pixel)[0], (*pixel)[1]},
          (*label)[0],
          (*label)[1]};
}

ParameterRule rule_from_flag(ParameterRule::Kind kind, const std::string& flag) {
  ParameterRule rule{flag, kind, {}, 0.0};
  const std::size_t equals = flag.find('=');
  rule.pattern = flag.substr(0, equals);
  const std::string value = equals == std::string::npos ? "" : flag.substr(equals + 1);
  if (kind == ParameterRule::Kind::kFixed && !value.empty()) rule.value = number(value, flag);
  if (kind == ParameterRule::Kind::kPrior) {
    const std::size_t colon = value.find(':');
    if (colon == std::string::npos) {
      throw Error(ErrorKind::kBadInput, fmt::format("--prior '{}' must be NAME=MEAN:SIGMA, as in left.fx=500:5", flag));
    }
    rule.value = number(value.substr(0, colon), flag);
    rule.sigma = number(value.substr(colon + 1), flag);
  }
  return rule;
}

}  // namespace raybundle::apps
