// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mrcal_peer.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "raybundle/geometry/rotation.hpp"

namespace raybundle::bench {
namespace {

const std::map<std::string_view, std::string> kLenses{{"pinhole", "LENSMODEL_PINHOLE"},
                                                      {"brown_conrady", "LENSMODEL_OPENCV5"},
                                                      {"rational", "LENSMODEL_OPENCV8"},
                                                      {"thin_prism", "LENSMODEL_OPENCV12"}};

/// Focal length that puts the rim of the image where the lens has it, were the lens stereographic: what a user reads
/// off the data sheet of field and sensor.
double stereographic_focal_px(const Camera& camera) {
  const double half_side = 0.5 * std::max(camera.size.width, camera.size.height);
  const auto rim = ray_from_pixel(camera, {camera.cx() + half_side, camera.cy()});
  if (!rim) return camera.fx();
  const double angle = std::atan2(rim->head<2>().norm(), rim->z());
  return half_side / (2.0 * std::tan(0.5 * angle));
}

void write_rig(std::ostream& out, const testing::RandomRig& rig) {
  const Camera& camera = rig.truth.cameras[0];
  const Target& board = rig.problem.targets[0];
  const double square = board.points[1].x_in_target.x();
  const int columns = static_cast<int>(std::lround(board.points.back().x_in_target.x() / square)) + 1;
  const int rows = static_cast<int>(board.points.size()) / columns;
  out << kLenses.at(model_name(camera.model)) << ' ' << camera.size.width << ' ' << camera.size.height << ' '
      << stereographic_focal_px(camera) << ' ' << columns << ' ' << rows << ' ' << square << ' '
      << rig.problem.views.size() << '\n';
  for (std::size_t v = 0; v < rig.problem.views.size(); ++v) {
    std::ostringstream corners;
    corners.precision(12);
    int count = 0;
    const std::vector<Observation>& observations = rig.problem.views[v].observations;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      if (rig.truth.fates[v][i] != ObservationFate::kUsed) continue;
      corners << ' ' << observations[i].point_id << ' ' << observations[i].pixel.x() << ' '
              << observations[i].pixel.y();
      ++count;
    }
    out << count << corners.str() << '\n';
  }
}

std::optional<BundleState> read_answer(const std::string& line, const testing::RandomRig& rig) {
  std::istringstream words(line);
  std::vector<double> values;
  for (double value; words >> value;) values.push_back(value);
  BundleState state = rig.truth;
  Eigen::VectorXd& parameters = state.cameras[0].parameters;
  const auto count = static_cast<std::size_t>(parameters.size());
  if (values.size() != count + 6 * state.poses.size()) return std::nullopt;
  for (std::size_t k = 0; k < count; ++k) parameters[static_cast<Eigen::Index>(k)] = values[k];
  for (std::size_t v = 0; v < state.poses.size(); ++v) {
    const double* pose = values.data() + count + 6 * v;
    state.poses[v].rig_from_target.rotation = Eigen::Quaterniond(rotation_from_vector({pose[0], pose[1], pose[2]}));
    state.poses[v].rig_from_target.translation << pose[3], pose[4], pose[5];
  }
  return state;
}

}  // namespace

bool mrcal_has(std::string_view model) { return kLenses.contains(model); }

bool mrcal_is_there() {
  static const bool there = std::system("/usr/bin/python3 -c 'import mrcal' >/dev/null 2>&1") == 0;
  return there;
}

std::vector<std::optional<BundleState>> calibrate_with_mrcal(const std::vector<testing::RandomRig>& rigs) {
  const std::string name = (std::filesystem::temp_directory_path() / "raybundle_mrcal_").string();
  const std::string asked = name + std::to_string(getpid()) + ".txt", answered = asked + ".answers";
  {
    std::ofstream out(asked);
    out.precision(12);
    for (const testing::RandomRig& rig : rigs) write_rig(out, rig);
  }
  const std::string command = "/usr/bin/python3 '" RAYBUNDLE_SOURCE_DIR "/bench/support/mrcal_peer.py' '" + asked +
                              "' '" + answered + "' >/dev/null 2>&1";
  const bool done = std::system(command.c_str()) == 0;
  std::vector<std::optional<BundleState>> answers(rigs.size());
  std::ifstream in(answered);
  std::string line;
  for (std::size_t i = 0; done && i < rigs.size() && std::getline(in, line); ++i)
    answers[i] = read_answer(line, rigs[i]);
  std::filesystem::remove(asked);
  std::filesystem::remove(answered);
  return answers;
}

}  // namespace raybundle::bench
