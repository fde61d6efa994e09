// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "raybundle/geometry/error.hpp"
#include "raybundle/synthetic/rig.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

std::string rig_text() {
  std::ifstream stream(RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml");
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string complaint(const std::string& text) {
  try {
    rig_from_text(text, "rig.toml");
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

TEST(RigReader, ReadsTheRigOfThePaper) {
  const SimulatedRig rig = rig_from_text(rig_text(), "rig.toml");
  ASSERT_EQ(rig.cameras.size(), 1u);
  ASSERT_TRUE(rig.emitter);
  EXPECT_EQ(rig.emitter->grid.size(), 121);
  EXPECT_NEAR(rig.emitter->lattice_turn_rad, 12 * M_PI / 180, 1e-15);
  EXPECT_NEAR(rig.emitter->lens->radius_m, 0.009 * 0.517, 1e-15);
  EXPECT_EQ(rig.board.target.points.size(), 117u);
  EXPECT_DOUBLE_EQ(rig.board.print.sheet.low.x(), -0.08 - 0.02);
  // 130 x 100 degrees
  const Camera& camera = rig.cameras[0].camera;
  const auto degrees = [&](double u, double v) {
    const Eigen::Vector3d ray = *ray_from_pixel(camera, {u, v});
    return std::atan2(ray.head<2>().norm(), ray.z()) * 180 / M_PI;
  };
  EXPECT_NEAR(degrees(0, camera.cy()) + degrees(639, camera.cy()), 130, 4);
  EXPECT_NEAR(degrees(camera.cx(), 0) + degrees(camera.cx(), 479), 100, 4);
}

TEST(RigReader, ReadsLightAndSensor) {
  const std::string text =
      replaced(rig_text(), "full_well_e = 10000", "bits = 10\nfull_well_e = 7000\nexposure = 1.5") +
      "\n[light]\nambient_W_m2 = 1.0\nsun_W_m2 = 4.0\nbackground_m = 2.0\n";
  const SimulatedRig rig = rig_from_text(text, "rig.toml");
  EXPECT_EQ(rig.cameras[0].sensor.bits, 10);
  EXPECT_EQ(rig.cameras[0].sensor.full_well_e, 7000);
  EXPECT_EQ(rig.cameras[0].sensor.exposure, 1.5);
  EXPECT_EQ(rig.light.ambient_W_m2, 1.0);
  EXPECT_EQ(rig.light.sun_W_m2, 4.0);
  EXPECT_EQ(rig.light.background_m, 2.0);
}

TEST(RigReader, NamesLineAndFieldOfMistakes) {
  const std::string text = rig_text();
  EXPECT_THAT(complaint(replaced(text, "columns = 11", "colums = 11")), HasSubstr("needs a field 'columns'"));
  EXPECT_THAT(complaint(replaced(text, "divergence_rad", "divergense_rad")),
              HasSubstr("Did you mean \"divergence_rad\""));
  EXPECT_THAT(complaint(replaced(text, "kannala_brandt", "kanala_brandt")), HasSubstr("Did you mean"));
  EXPECT_THAT(complaint(replaced(text, "k4 = 0.0002", "k5 = 0.0002")), HasSubstr("parameters needs a field 'k4'"));
  EXPECT_THAT(complaint(replaced(text, "[90.0, 70.0]", "[175.0, 70.0]")), HasSubstr("cannot spread its beams to 175"));
  EXPECT_THAT(complaint(replaced(text, "[0.25, 1.3]", "[1.3, 0.25]")), HasSubstr("[nearest, farthest]"));
  EXPECT_THAT(complaint(replaced(text, "chessboard", "charuco")), HasSubstr("'charuco' is not printed here"));
  EXPECT_THAT(complaint(replaced(text, "[poses]", "[pose]")), HasSubstr("unknown field 'pose'"));
  EXPECT_THAT(complaint(replaced(text, "name = \"camera\"", "name = \"camera\"\nturned_deg = [0, 0, 1]")),
              HasSubstr("first camera's frame is the rig frame"));
  EXPECT_THAT(complaint("[[camera]\n"), HasSubstr("rig.toml:1: is not TOML"));
  EXPECT_THAT(complaint(""), HasSubstr("no [[camera]]"));
  EXPECT_THAT(complaint(replaced(text, "rows = 11", "rows = 11\nmissing = [[3, 11]]")), HasSubstr("[3, 11]"));
  EXPECT_THAT(complaint(replaced(text, "tilt_deg = 50.0", "tilt_deg = 95.0")), HasSubstr("rig.toml:50"));
  EXPECT_THAT(complaint(text + "\n[light]\nbackground_m = 0\n"), HasSubstr("background_m"));
  EXPECT_THAT(complaint(text + "\n[light]\nambient_W_m = 1\n"), HasSubstr("Did you mean \"ambient_W_m2\""));
  EXPECT_THAT(complaint(replaced(text, "full_well_e", "bits = 9\nfull_well_e")), HasSubstr("bits must be 8, 10 or 12"));
}

}  // namespace
}  // namespace raybundle::testing
