// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "problem.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/io/observations_file.hpp"
#include "synthetic_world.hpp"
#include "true_error_bound.hpp"

namespace raybundle::bench {
namespace {

using nlohmann::json;

void append(std::vector<double>& numbers, const Rigid3& transform) {
  for (int k = 0; k < 4; ++k) numbers.push_back(transform.rotation.coeffs()[k]);
  for (int k = 0; k < 3; ++k) numbers.push_back(transform.translation[k]);
}

void write_numbers(const std::filesystem::path& path, const std::vector<double>& numbers) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(numbers.data()),
               static_cast<std::streamsize>(numbers.size() * sizeof(double)));
  if (!stream.flush()) throw Error(ErrorKind::kIo, path.string() + ": cannot be written");
}

std::vector<double> read_numbers(const std::filesystem::path& path) {
  std::vector<double> numbers(std::filesystem::file_size(path) / sizeof(double));
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(numbers.size() * sizeof(double)));
  if (!stream) throw Error(ErrorKind::kIo, path.string() + ": cannot be read");
  return numbers;
}

std::vector<double> pixel_table(const PeerProblem& made) {
  const std::size_t corners = static_cast<std::size_t>(made.columns * made.rows), frames = made.problem.frames.size();
  std::vector<double> pixels(made.problem.cameras.size() * frames * corners * 2, std::nan(""));
  for (const TargetView& view : made.problem.views) {
    const std::size_t first =
        (static_cast<std::size_t>(view.camera) * frames + static_cast<std::size_t>(view.frame)) * corners;
    for (const Observation& observation : view.observations) {
      for (int axis = 0; axis < 2; ++axis) {
        pixels[2 * (first + static_cast<std::size_t>(observation.point_id)) + static_cast<std::size_t>(axis)] =
            observation.pixel[axis];
      }
    }
  }
  return pixels;
}

// A start for solvers that need one: poses some degrees and centimetres away.
std::vector<double> start_poses(const PeerProblem& made) {
  std::vector<double> numbers;
  Eigen::Matrix<double, 6, 1> motion;
  motion << 0.02, -0.01, 0.01, 0.01, 0.005, 0.02;
  for (const BoardPose& pose : made.truth.poses) append(numbers, perturbed(pose.rig_from_target, motion));
  return numbers;
}

json camera_json(const PeerProblem& made, std::size_t c) {
  const Camera& camera = made.truth.cameras[c];
  std::vector<double> place;
  append(place, made.truth.camera_from_rig[c]);
  const TrueErrorBound flat = true_error_bound(made, static_cast<int>(c), false);
  const TrueErrorBound bent = true_error_bound(made, static_cast<int>(c), true);
  return {{"name", made.problem.cameras[c].name},
          {"model", model_name(camera.model)},
          {"width", camera.size.width},
          {"height", camera.size.height},
          {"parameters", std::vector<double>(camera.parameters.begin(), camera.parameters.end())},
          {"camera_from_rig", place},
          {"grid_points", made.grid[c].size()},
          {"bound_rms_px", flat.rms_px},
          {"bound_with_shape_rms_px", bent.rms_px}};
}

}  // namespace

void write_problem(const std::filesystem::path& folder, const PeerProblem& made) {
  std::filesystem::create_directories(folder);
  json root{{"family", made.family},
            {"columns", made.columns},
            {"rows", made.rows},
            {"square_m", made.square_m},
            {"frames", made.problem.frames.size()},
            {"views", made.problem.views.size()},
            {"sigma_px", made.problem.views.front().observations.front().sigma_px},
            {"bend_m", made.truth.shapes.front().bend_x_m},
            {"cameras", json::array()}};
  std::vector<double> poses, grid;
  for (std::size_t c = 0; c < made.problem.cameras.size(); ++c) {
    root["cameras"].push_back(camera_json(made, c));
    for (const GridPoint& point : made.grid[c]) {
      for (int k = 0; k < 3; ++k) grid.push_back(point.ray_in_camera[k]);
      for (int k = 0; k < 2; ++k) grid.push_back(point.pixel[k]);
    }
  }
  for (const BoardPose& pose : made.truth.poses) append(poses, pose.rig_from_target);
  write_numbers(folder / "pixels.f64", pixel_table(made));
  write_numbers(folder / "poses.f64", poses);
  write_numbers(folder / "start.f64", start_poses(made));
  write_numbers(folder / "grid.f64", grid);
  ObservationsFile observations{made.problem, {}};
  for (const ProblemCamera& camera : made.problem.cameras) observations.models.emplace_back(camera.model);
  write_observations(folder / "observations.json", observations);
  std::ofstream stream(folder / "problem.json");
  stream << root.dump(1) << '\n';
  if (!stream.flush()) throw Error(ErrorKind::kIo, (folder / "problem.json").string() + ": cannot be written");
}

PeerProblem read_problem(const std::filesystem::path& folder) {
  std::ifstream stream(folder / "problem.json");
  const json root = json::parse(stream);
  PeerProblem made;
  made.family = root.at("family");
  made.columns = root.at("columns");
  made.rows = root.at("rows");
  made.square_m = root.at("square_m");
  made.problem.targets = {testing::grid_target("board", made.columns, made.rows, made.square_m)};
  const std::vector<double> pixels = read_numbers(folder / "pixels.f64"), grid = read_numbers(folder / "grid.f64");
  const int corners = made.columns * made.rows, frames = root.at("frames");
  const double sigma_px = root.at("sigma_px");
  for (int frame = 0; frame < frames; ++frame) made.problem.frames.push_back(std::to_string(frame));
  std::size_t at = 0, grid_at = 0;
  for (const json& camera : root.at("cameras")) {
    const int c = static_cast<int>(made.problem.cameras.size());
    made.problem.cameras.push_back({camera.at("name"),
                                    *model_named(camera.at("model").get<std::string>()),
                                    {camera.at("width"), camera.at("height")},
                                    {},
                                    {}});
    for (int frame = 0; frame < frames; ++frame) {
      TargetView view{c, frame, 0, {}, {}};
      view.observations.reserve(static_cast<std::size_t>(corners));
      for (int id = 0; id < corners; ++id, at += 2) {
        if (std::isnan(pixels[at])) continue;
        view.observations.push_back({{pixels[at], pixels[at + 1]}, sigma_px, id});
      }
      if (!view.observations.empty()) made.problem.views.push_back(std::move(view));
    }
    std::vector<GridPoint> points(camera.at("grid_points").get<std::size_t>());
    for (GridPoint& point : points) {
      const double* numbers = &grid[grid_at];
      point = {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4]}};
      grid_at += 5;
    }
    made.grid.push_back(std::move(points));
  }
  return made;
}

}  // namespace raybundle::bench
