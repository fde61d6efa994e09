// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "name_list.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/observation_tables.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"

namespace raybundle {
namespace {

std::vector<std::string> names_of(const std::map<std::string, ImageSize>& sizes) {
  std::vector<std::string> names;
  for (const auto& [name, size] : sizes) names.push_back(name);
  return names;
}

enum Column : std::size_t { kCamera, kFrame, kPoint, kU, kV, kSigma };

Observation observation_from(const CsvTable& table, const CsvRow& row, const Target& target) {
  Observation observation{.pixel = {number_in(table, row, kU, "u"), number_in(table, row, kV, "v")},
                          .point_id = whole_number_in(table, row, kPoint, "point_id")};
  if (!row.fields[kSigma].empty()) observation.sigma_px = number_in(table, row, kSigma, "sigma");
  if (!(observation.sigma_px > 0)) fail_at(table, row, "sigma is " + row.fields[kSigma] + "; it must be positive");
  if (target.find(observation.point_id) == nullptr) {
    fail_at(table, row,
            "point " + std::to_string(observation.point_id) + " is not on the board, which has " +
                std::to_string(target.points.size()) + " points; is the board size right?");
  }
  return observation;
}

}  // namespace

CalibrationProblem observations_from_csv_text(std::string_view text, const std::string& name, const Target& target,
                                              const std::map<std::string, ImageSize>& sizes) {
  CsvTable table = csv_from_text(text, name);
  arrange_columns(table, {{"camera", "frame", "point_id", "u", "v"}, {"sigma"}});
  if (table.rows.empty()) throw Error(ErrorKind::kBadInput, "there are no observations in the file", name);

  CalibrationProblem problem;
  problem.targets = {target};
  NameList cameras, frames;
  std::map<std::pair<int, int>, std::size_t> view_of;
  std::vector<std::set<int>> ids;  // of each view
  for (const CsvRow& row : table.rows) {
    const std::string& camera = row.fields[kCamera];
    const auto size = sizes.find(camera);
    if (size == sizes.end()) {
      fail_at(table, row,
              "the image size of camera " + in_quotes(camera) + " is not given; give it as NAME=WIDTHxHEIGHT." +
                  did_you_mean(camera, names_of(sizes)));
    }
    const std::pair<int, int> place{cameras.index_of(camera), frames.index_of(row.fields[kFrame])};
    if (cameras.names().size() > problem.cameras.size()) {
      problem.cameras.push_back({camera, ModelId{}, size->second, std::nullopt, std::nullopt});
    }
    const auto [view, is_new] = view_of.try_emplace(place, problem.views.size());
    if (is_new) {
      problem.views.push_back({place.first, place.second, 0, {}, {}});
      ids.emplace_back();
    }
    problem.views[view->second].observations.push_back(observation_from(table, row, target));
    if (!ids[view->second].insert(problem.views[view->second].observations.back().point_id).second) {
      fail_at(table, row, "the camera observes this point a second time in this frame; leave one line out");
    }
  }
  problem.frames = frames.names();
  for (const auto& [camera, size] : sizes) {
    if (cameras.contains(camera)) continue;
    throw Error(ErrorKind::kBadInput,
                "an image size is given for camera " + in_quotes(camera) + ", which has no observations." +
                    did_you_mean(camera, cameras.names()),
                name);
  }
  check_as_part_of(name, problem);
  return problem;
}

CalibrationProblem read_observations_csv(const std::filesystem::path& path, const Target& target,
                                         const std::map<std::string, ImageSize>& sizes) {
  return observations_from_csv_text(text_of_file(path), path.string(), target, sizes);
}

}  // namespace raybundle
