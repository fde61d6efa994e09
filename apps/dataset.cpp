// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dataset.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "beam_grid.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/number.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/targets/board_toml.hpp"
#include "raybundle/toml/toml_reader.hpp"

namespace raybundle::apps {
namespace {

DatasetCamera camera_from(TomlReader& reader) {
  DatasetCamera camera{reader.text("name"), reader.texts("images"), reader.text("model"), {}};
  if (reader.has("laser_on")) camera.laser_on = reader.texts("laser_on");
  reader.refuse_unknown_keys();
  model_from_name(camera.model, reader.place());
  return camera;
}

LaserGrid grid_from(const std::string& word, const TomlReader& reader) {
  if (const std::optional<LaserGrid> grid = beam_grid_from_word(word, 1)) return *grid;
  reader.fail(nullptr,
              fmt::format("[laser].grid is '{}', but must be COLUMNSxROWS of beams up to 64x64, as \"11x11\"", word));
}

int beam_from(const toml::node& node, const LaserGrid& grid, const TomlReader& reader) {
  const toml::array* label = node.as_array();
  if (label == nullptr || label->size() != 2 || !(*label)[0].is_number() || !(*label)[1].is_number()) {
    reader.fail(&node, "a beam, [row, column], must be two numbers in brackets");
  }
  const double row = *(*label)[0].value<double>(), column = *(*label)[1].value<double>();
  const bool on_grid = row >= 0 && row < grid.rows && column >= 0 && column < grid.columns;
  if (!on_grid || row != std::floor(row) || column != std::floor(column)) {
    reader.fail(&node, fmt::format("there is no beam in row {} and column {} of {} rows and {} columns, counted from 0",
                                   row, column, grid.rows, grid.columns));
  }
  return grid.index(static_cast<int>(row), static_cast<int>(column));
}

DatasetAnchor anchor_from(TomlReader& reader, const LaserGrid& grid) {
  const toml::node* beam = reader.get("beam");
  if (!reader.has("pixel") || beam == nullptr) {
    reader.fail(nullptr, "[laser].anchor needs pixel = [u, v] and beam = [row, column]");
  }
  const std::vector<double> pixel = reader.numbers("pixel", 2);
  const int index = beam_from(*beam, grid, reader);
  DatasetAnchor anchor{
      reader.text("camera"), reader.text("frame"), {pixel[0], pixel[1]}, grid.row(index), grid.column(index)};
  reader.refuse_unknown_keys();
  return anchor;
}

DatasetLaser laser_from(TomlReader& reader) {
  DatasetLaser laser{grid_from(reader.text("grid"), reader), {}, {}, {}};
  if (const toml::node* brightest = reader.get("brightest"))
    laser.brightest = beam_from(*brightest, laser.grid, reader);
  if (const toml::node* missing = reader.get("missing")) {
    if (!missing->is_array()) reader.fail(missing, "[laser].missing must be a list of beams, as [[0, 0], [0, 10]]");
    for (const toml::node& beam : *missing->as_array()) laser.missing.push_back(beam_from(beam, laser.grid, reader));
  }
  if (auto anchor = reader.table("anchor", "[laser].anchor")) laser.anchor = anchor_from(*anchor, laser.grid);
  reader.refuse_unknown_keys();
  return laser;
}

SurveyInput survey_from(TomlReader& reader, const std::filesystem::path& folder) {
  SurveyInput survey;
  survey.landmarks = (folder / reader.text("landmarks")).generic_string();
  survey.sightings = (folder / reader.text("sightings")).generic_string();
  survey.height = reader.text("height", "");
  survey.sigma_px = reader.positive("sigma_px", survey.sigma_px);
  if (reader.has("origin")) survey.origin = reader.numbers("origin", 3);  // latitude, longitude, height
  reader.refuse_unknown_keys();
  return survey;
}

DatasetBoard board_from(TomlReader& reader, const std::string& folder, std::size_t index) {
  const std::string name = reader.text("name", index == 0 ? "board" : fmt::format("board{}", index + 1));
  return {name, board_from_toml(reader, folder)};
}

ParameterRule rule_from(TomlReader& reader) {
  const auto number = [&](const char* key) {
    return reader.has(key) ? std::optional(reader.number(key)) : std::nullopt;
  };
  ParameterRule rule;
  rule.pattern = reader.text("name");
  const std::optional<double> fixed = number("fixed"), prior = number("prior"), sigma = number("sigma");
  const bool free = reader.flag("free", false), said_free = reader.has("free");
  reader.refuse_unknown_keys();
  if (fixed.has_value() + prior.has_value() + free != 1 || free != said_free ||
      prior.has_value() != sigma.has_value()) {
    reader.fail(nullptr, "[[parameter]] needs one of: fixed = VALUE; prior = MEAN with sigma = SIGMA; free = true");
  }
  rule.kind = prior ? ParameterRule::Kind::kPrior : fixed ? ParameterRule::Kind::kFixed : ParameterRule::Kind::kFree;
  rule.value = fixed ? fixed : prior;
  rule.sigma = sigma.value_or(0.0);
  return rule;
}

void read_options(TomlReader& reader, CalibrateOptions& options) {
  CalibrateOptions::for_each_option(options, [&]<typename T>(const char* name, const char*, const char*, T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = reader.flag(name, value);
    } else if constexpr (std::is_same_v<T, int>) {
      if (reader.has(name)) value = reader.whole(name, 0, 1'000'000);
    } else {
      value = reader.number(name, value);
    }
  });
  reader.refuse_unknown_keys();
  check(options, reader.place());
}

// The section that may stand there once.
std::optional<TomlReader> only(TomlReader& root, const char* key, const char* advice) {
  std::vector<TomlReader> found = root.tables(key);
  if (found.size() > 1) found[1].fail(nullptr, fmt::format("there is a second [{}]; {}", key, advice));
  return found.empty() ? std::nullopt : std::optional(std::move(found[0]));
}

double number(const std::string& text, const std::string& flag) {
  const std::optional<double> value = number_from<double>(text);
  if (!value || !std::isfinite(*value)) {
    throw Error(ErrorKind::kBadInput, fmt::format("'{}' is not a number in '{}'", text, flag));
  }
  return *value;
}

// Whether `name` is `theirs`, or a part of it as people say it: equi of pinhole-equi, opencv8 of LENSMODEL_OPENCV8.
bool is_called(std::string_view name, std::string_view theirs) {
  const auto same = [](char a, char b) { return std::tolower(std::uint8_t(a)) == std::tolower(std::uint8_t(b)); };
  const auto separates = [](char c) { return c == '-' || c == '_'; };
  if (name.empty() || name.size() > theirs.size()) return false;
  const std::string_view head = theirs.substr(0, name.size()), tail = theirs.substr(theirs.size() - name.size());
  const bool starts = std::ranges::equal(name, head, same), ends = std::ranges::equal(name, tail, same);
  if (name.size() == theirs.size()) return starts;
  return (starts && separates(theirs[name.size()])) || (ends && separates(theirs[theirs.size() - name.size() - 1]));
}

// Our models that another program or library calls by this name: plumb_bob, pinhole-equi, fisheye.
std::vector<std::string> models_called_elsewhere(std::string_view name) {
  std::vector<std::string> ours;
  for (std::string_view known : model_names()) {
    const auto called = [&](const ForeignName& foreign) { return is_called(name, foreign.name); };
    if (std::ranges::any_of(foreign_names(*model_named(known)), called)) ours.emplace_back(known);
  }
  return ours;
}

}  // namespace

ModelId model_from_name(const std::string& name, const std::string& where) {
  if (const std::optional<ModelId> model = model_named(name)) return *model;
  std::vector<std::string> names;
  for (std::string_view known : model_names()) names.emplace_back(known);
  const std::vector<std::string> meant = models_called_elsewhere(name);
  const std::string hint = meant.empty() ? did_you_mean(name, names)
                                         : fmt::format(" Here it is called \"{}\".", fmt::join(meant, "\" or \""));
  throw Error(ErrorKind::kBadInput, fmt::format("there is no camera model '{}'.{}", name, hint), where);
}

Dataset dataset_from_text(const std::string& text, const std::string& path) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') {
    throw Error(ErrorKind::kBadInput,
                "this is JSON, not a dataset.toml: corners found before are given with --observations", path);
  }
  const toml::table table = toml_from_text(text, path);
  TomlReader reader(table, "the file", path);
  Dataset dataset;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  dataset.folder = folder.string();
  for (TomlReader& section : reader.tables("target")) {
    const DatasetBoard board = board_from(section, dataset.folder, dataset.boards.size());
    if (std::ranges::find(dataset.boards, board.name, &DatasetBoard::name) != dataset.boards.end()) {
      section.fail(nullptr, fmt::format("two [[target]] are called '{}'; rename one", board.name));
    }
    dataset.boards.push_back(board);
  }
  for (TomlReader& section : reader.tables("camera")) dataset.cameras.push_back(camera_from(section));
  if (auto section = only(reader, "laser", "a rig has one")) dataset.laser = laser_from(*section);
  if (auto section = only(reader, "survey", "put all landmarks into one"))
    dataset.survey = survey_from(*section, folder);
  for (TomlReader& section : reader.tables("parameter")) dataset.rules.push_back(rule_from(section));
  for (TomlReader& section : reader.tables("calibrate")) read_options(section, dataset.options);
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
  if (kind == ParameterRule::Kind::kFree && equals != std::string::npos) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("--free '{}' must be a NAME alone, as in left.fx: start values come from --start", flag));
  }
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
