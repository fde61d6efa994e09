// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <toml++/toml.h>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

double angle_deg(const Rigid3& transform) { return angle_between(transform, Rigid3{}) * 180.0 / M_PI; }

// camera_from_world of caliscope's camera_array.toml.
std::vector<Rigid3> caliscope_reference(const fs::path& file) {
  const toml::table table = toml::parse_file(file.string());
  std::vector<Rigid3> cameras;
  for (int c = 0; c < 4; ++c) {
    const toml::node_view camera = table["cameras"][std::to_string(c)];
    Eigen::Matrix3d rotation;
    Rigid3 camera_from_world;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        rotation(static_cast<int>(i), static_cast<int>(j)) = camera["rotation"][i][j].value_or(0.0);
      }
      camera_from_world.translation[static_cast<int>(i)] = camera["translation"][i].value_or(0.0);
    }
    camera_from_world.rotation = Eigen::Quaterniond(rotation).normalized();
    cameras.push_back(camera_from_world);
  }
  return cameras;
}

// The webcams expose up to half a frame apart while the board is carried around, and the reference has its intrinsics
// from other videos: 3 % of a baseline and 4 degrees are what two honest answers may differ by.
TEST(CalibratesARig, OfFourWebcamsFromTheirVideos) {
  const char* folder = "caliscope/charuco_calibration";
  RAYBUNDLE_NEEDS_DATA(folder);
  const fs::path place = fresh_folder();
  std::vector<std::string> arguments{"--target", "charuco:4x5:54mm:40.5mm:DICT_4X4_1000:inverted", "--model",
                                     "brown_conrady"};
  for (int c = 0; c < 4; ++c) {
    const fs::path video = real_data(folder) / "calibration/extrinsic" / fmt::format("cam_{}.mp4", c);
    arguments.insert(arguments.end(), {"--camera", fmt::format("cam{}={}", c, video.string())});
  }
  ASSERT_TRUE(calibrate(place, arguments).contains("cameras"));
  const nlohmann::json calibration = json_of(place / "out" / "calibration.json");
  const std::vector<Rigid3> reference = caliscope_reference(real_data(folder) / "camera_array.toml");
  for (int a = 0; a < 4; ++a) {
    for (int b = a + 1; b < 4; ++b) {
      const std::string from = fmt::format("cam{}", a), to = fmt::format("cam{}", b);
      const Rigid3 theirs = reference[b] * reference[a].inverse();
      const Rigid3 ours = camera_from_rig(calibration, to) * camera_from_rig(calibration, from).inverse();
      EXPECT_NEAR(ours.translation.norm() / theirs.translation.norm(), 1.0, 0.03) << from << " to " << to;
      EXPECT_LT(angle_deg(ours * theirs.inverse()), 4.0) << from << " to " << to;
    }
  }
}

// mrcal's two made-up cameras, from its own poses of them; noise 0.3 px in u and in v, so 0.42 px rms.
TEST(CalibratesARig, FromMrcalsCornerTable) {
  RAYBUNDLE_NEEDS_DATA("mrcal_ultrawide");
  const fs::path place = fresh_folder();
  const nlohmann::json report = calibrate(
      place, {"--observations", (real_data("mrcal_ultrawide") / "synthetic-board-observations.vnl").string(),
              "--target", "chessboard:10x10:100mm", "--camera", "cam0=*-cam0.xxx", "--camera", "cam1=*-cam1.xxx",
              "--image-size", "cam0=4000x2200", "--image-size", "cam1=4000x2200", "--model", "kannala_brandt"});
  ASSERT_TRUE(report.contains("cameras"));
  for (const char* name : {"cam0", "cam1"}) {
    EXPECT_EQ(camera_in(report, name).at("views_used"), 3) << name;
    EXPECT_LT(camera_in(report, name).at("rms_px"), 0.5) << name;
  }
  const auto posed = [](const Eigen::Vector3d& rotation, const Eigen::Vector3d& translation) {
    Rigid3 transform;
    transform.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(rotation.norm(), rotation.normalized()));
    transform.translation = translation;
    return transform;
  };
  const Rigid3 truth = posed({0.2, 0.1, -0.01}, {2, 2, -2.5}) * posed({0.02, -0.3, -0.01}, {1, 2, -3}).inverse();
  const Rigid3 ours = camera_from_rig(json_of(place / "out" / "calibration.json"), "cam1");
  // Three boards hardly tell the lenses from the poses, so the answer is good to a percent.
  EXPECT_NEAR(ours.translation.norm(), truth.translation.norm(), 0.03 * truth.translation.norm());
  EXPECT_LT(angle_deg(ours * truth.inverse()), 1.5);
}

/// Folder with OpenCV's stereo pairs, those of some numbers with left and right exchanged.
fs::path pairs_exchanged(const std::vector<int>& numbers) {
  const fs::path folder = fresh_folder() / "pairs";
  fs::create_directories(folder);
  for (const fs::directory_entry& entry : fs::directory_iterator(real_data("opencv_stereo_chess"))) {
    std::string name = entry.path().filename().string();
    const bool left = name.starts_with("left"), right = name.starts_with("right");
    if ((!left && !right) || entry.path().extension() != ".jpg") continue;
    const std::string number = name.substr(left ? 4 : 5);
    if (std::ranges::count(numbers, std::stoi(number)) > 0) name = (left ? "right" : "left") + number;
    fs::copy_file(entry.path(), folder / name);
  }
  return folder;
}

std::string warnings_of_pairs(const fs::path& folder) {
  const nlohmann::json report = calibrate(
      folder, {"--target", "chessboard:9x6:25mm", "--model", "brown_conrady", "--camera",
               "left=" + (folder / "left*.jpg").string(), "--camera", "right=" + (folder / "right*.jpg").string()});
  return report["warnings"].dump();
}

TEST(CalibratesARig, AndNamesImagesThatAreExchanged) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  EXPECT_EQ(warnings_of_pairs(pairs_exchanged({})).find("exchanged"), std::string::npos);
  const std::string some = warnings_of_pairs(pairs_exchanged({3, 7, 12}));
  EXPECT_NE(some.find("images of left and right look exchanged in frames 3, 7, 12"), std::string::npos) << some;
  const std::string all = warnings_of_pairs(pairs_exchanged({1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14}));
  EXPECT_NE(all.find("right lies 83 mm to the left of left"), std::string::npos) << all;
}

}  // namespace
}  // namespace raybundle::testing
