// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "real_sets.hpp"

#include <cstdio>
#include <cstdlib>

#include "raybundle/io/observations_file.hpp"
#include "real_data.hpp"

namespace raybundle::bench {
namespace {

std::string quoted(const std::string& text) { return "'" + text + "'"; }

}  // namespace

std::vector<RealSet> real_sets() {
  const std::string fisheye = "sourishg_fisheye_stereo/imgs", stereo = "opencv_stereo_chess",
                    bumblebee = "boofcv_stereo/Bumblebee2_Chess", charuco = "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000";
  return {{"opencv_left", stereo, "chessboard:9x6:25mm", {"left=left*.jpg"}},
          {"opencv_stereo", stereo, "chessboard:9x6:25mm", {"left=left*.jpg", "right=right*.jpg"}},
          {"boofcv_left", bumblebee, "chessboard:6x4:30mm", {"left=left*.jpg"}},
          {"boofcv_stereo", bumblebee, "chessboard:6x4:30mm", {"left=left*.jpg", "right=right*.jpg"}},
          {"sourishg_left", fisheye, "chessboard:9x6:24.23mm", {"left=left*.jpg"}},
          {"sourishg_right", fisheye, "chessboard:9x6:24.23mm", {"right=right*.jpg"}},
          {"sourishg_stereo", fisheye, "chessboard:9x6:24.23mm", {"left=left*.jpg", "right=right*.jpg"}},
          {"camodocal", "camodocal_fisheye/images", "chessboard:9x6:120mm", {"front=*.png"}},
          {"ocam_fisheye1", "ocam/Fisheye1", "chessboard:8x6:32.5mm", {"fisheye=*.jpg"}},
          {"photonvision_480", "photonvision_charuco_small/lifecam_480", charuco, {"lifecam=*.jpg"}},
          {"photonvision_1280",
           "photonvision_charuco_small/lifecam_1280_old_pattern",
           charuco + ":legacy",
           {"lifecam=*.jpg"}},
          {"linelight", "linelight_zhao/calib_picture", "circles:7x7:20mm", {"camera=*.jpg"}},
          {"caliscope",
           "caliscope/charuco_calibration/calibration/extrinsic",
           "charuco:4x5:54mm:40.5mm:DICT_4X4_1000:inverted",
           {"cam0=cam_0.mp4", "cam1=cam_1.mp4", "cam2=cam_2.mp4", "cam3=cam_3.mp4"}}};
}

std::optional<CalibrationProblem> observations_of(const RealSet& set, const std::filesystem::path& program) {
  const std::filesystem::path folder = testing::real_data() / set.folder;
  if (!std::filesystem::is_directory(folder)) return std::nullopt;
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("raybundle_" + set.name + ".json");
  std::string command = quoted(program.string()) + " detect --target " + quoted(set.board);
  for (const std::string& camera : set.cameras) {
    const auto at = camera.find('=') + 1;
    command += " --camera " + quoted(camera.substr(0, at) + (folder / camera.substr(at)).string());
  }
  command += " -o " + quoted(file.string()) + " >/dev/null 2>&1";
  if (std::system(command.c_str()) != 0) {
    std::printf("  `%s` failed\n", command.c_str());
    return std::nullopt;
  }
  CalibrationProblem problem = read_observations(file).problem;
  std::filesystem::remove(file);
  return problem;
}

}  // namespace raybundle::bench
