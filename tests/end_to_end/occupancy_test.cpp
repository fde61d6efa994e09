// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>

#include "occupancy_learning.hpp"
#include "occupancy_scenes.hpp"
#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVehicle = R"([vehicle]
dashboard_x_m = 0.70
dashboard_top_m = 0.46
zone_floor_m = 0.30
zone_half_width_m = 0.32
critical_m = 0.20
out_of_position_m = 0.40
[sensor]
rows = 11
columns = 11
rotation_xyzw = [0, 0, 0, 1]
translation_m = [0, 0, 0]
viewpoint_m = [0.46, 0.36, 0.90]
)";

// A base of few scenes; learnt once for all tests.
const std::string& learnt_base() {
  static const std::string path = [] {
    const std::string base = (fresh_folder() / "seats.rbcases").string();
    const ProgramRun run =
        raybundle_program({"occupancy", "learn", "--scenes", "1000", "--neighbours", "5", "-o", base});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return base;
  }();
  return path;
}

// Points of a simulated cabin as `reconstruct structured-light` writes them, the camera's frame being the vehicle's.
std::string points_text(CabinClass wanted, std::uint64_t seed) {
  const apps::MeasuredScene scene = apps::measured_scene(
      {apps::SensorKind::kStructuredLight, {CockpitGenerator::kTraining, seed, wanted, 0.0}, {11, 11}, {128, 128}});
  nlohmann::json points = nlohmann::json::array();
  for (const ScenePoint& point : scene.points) {
    const double variance = point.sigma_m * point.sigma_m / 3;
    const Eigen::Vector3d& x = point.x_in_vehicle;
    points.push_back({{"row", point.ray / 11},
                      {"column", point.ray % 11},
                      {"x_in_camera_m", {x.x(), x.y(), x.z()}},
                      {"covariance_m2", {variance, 0, 0, 0, variance, 0, 0, 0, variance}}});
  }
  return nlohmann::json{{"format", "raybundle laser points"},
                        {"version", 1},
                        {"state", "OK"},
                        {"rows", 11},
                        {"columns", 11},
                        {"points", points}}
      .dump();
}

TEST(Occupancy, EvaluatesBothSplitsTheSameOnAnyNumberOfThreads) {
  const auto figures = [](const char* threads) {
    const ProgramRun run = raybundle_program(
        {"occupancy", "evaluate", learnt_base(), "--scenes", "16", "--frames", "1", "--threads", threads, "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  };
  const std::string one = figures("1");
  EXPECT_EQ(one, figures("3"));
  const auto json = nlohmann::json::parse(one);
  ASSERT_EQ(json["splits"].size(), 2u);
  for (const auto& split : json["splits"]) {
    EXPECT_EQ(split["scenes"], 16);
    EXPECT_EQ(split["dangerous"]["trials"], 16);
  }
}

// In another car, the truth is that of the moved points: here one point lies where somebody is nearest.
TEST(Occupancy, TheTruthFollowsIntoAnotherCar) {
  apps::SimulatedLearning how;
  how.car_lost = 0.0;
  int other_class = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    apps::MeasuredScene scene = apps::measured_scene({apps::SensorKind::kStructuredLight,
                                                      {CockpitGenerator::kTraining, seed, CabinClass::kPassenger, 0.0},
                                                      {11, 11},
                                                      {128, 128}});
    if (!std::isfinite(scene.truth.dashboard_distance_m)) continue;
    scene.points.push_back({0, scene.truth.nearest_place, 0.005});
    scene.parts.push_back(CabinPart::kBody);
    const apps::MeasuredScene other = apps::as_in_another_car(scene, how, seed);
    const double distance_m = other.layout.dashboard_x_m - other.points.back().x_in_vehicle.x();
    EXPECT_NEAR(other.truth.dashboard_distance_m, std::max(0.0, distance_m), 1e-12);
    EXPECT_EQ(other.truth.seat_class == CabinClass::kOutOfPosition, distance_m < other.layout.out_of_position_m);
    other_class += other.truth.seat_class != scene.truth.seat_class;
  }
  EXPECT_GT(other_class, 0);  // else nothing was shown
}

// A seat that is known moves with the car; of one that nobody knows, nothing is known there either.
TEST(Occupancy, TheSeatFollowsIntoAnotherCarIfItIsKnown) {
  apps::SimulatedLearning how;
  how.car_lost = 0.0;
  apps::MeasuredScene scene = apps::measured_scene(
      {apps::SensorKind::kStructuredLight, {CockpitGenerator::kTraining, 1, CabinClass::kEmpty, 0.0}, {11, 11}});
  EXPECT_FALSE(apps::as_in_another_car(scene, how, 1).seat);
  scene.seat = apps::seat_pose(scene.truth.seat);
  scene.points.push_back({0, scene.truth.seat.bight, 0.005});
  scene.parts.push_back(CabinPart::kDashboard);  // of which nothing is dented
  const apps::MeasuredScene other = apps::as_in_another_car(scene, how, 1);
  ASSERT_TRUE(other.seat);
  const Eigen::Vector3d& bight = other.points.back().x_in_vehicle;
  EXPECT_NEAR((other.seat->bight - Eigen::Vector2d(bight.x(), bight.z())).norm(), 0.0, 1e-12);
  EXPECT_GT((other.seat->bight - scene.seat->bight).norm(), 1e-3) << "a car that is not another one";
}

// What allows has to last three frames; an empty seat is never fired at.
TEST(Occupancy, ClassifiesFramesOfLaserPoints) {
  const fs::path folder = fresh_folder();
  write_text(folder / "vehicle.toml", kVehicle);
  write_text(folder / "empty.json", points_text(CabinClass::kEmpty, 5));
  const std::string frame = (folder / "empty.json").string();
  const ProgramRun run =
      raybundle_program({"occupancy", "classify", learnt_base(), frame, frame, frame, "--vehicle",
                         (folder / "vehicle.toml").string(), "--page", (folder / "seats.html").string(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto frames = nlohmann::json::parse(run.out)["frames"];
  ASSERT_EQ(frames.size(), 3u);
  for (const auto& answer : frames) EXPECT_NE(answer["airbag"], "fire");
  EXPECT_NE(text_of(folder / "seats.html").find("rays_through_zones"), std::string::npos);
}

TEST(Occupancy, SaysWhatIsWrongWithItsInput) {
  const fs::path folder = fresh_folder();
  write_text(folder / "vehicle.toml", kVehicle);
  write_text(folder / "points.json", points_text(CabinClass::kEmpty, 5));
  const auto classify = [&](const std::string& base, const std::string& points, const std::string& vehicle) {
    return raybundle_program(
        {"occupancy", "classify", base, (folder / points).string(), "--vehicle", (folder / vehicle).string()});
  };
  const std::string bytes = text_of(learnt_base());
  write_text(folder / "cut.rbcases", bytes.substr(0, bytes.size() / 2));
  EXPECT_EQ(classify((folder / "cut.rbcases").string(), "points.json", "vehicle.toml").exit_code, 2);
  EXPECT_EQ(classify((folder / "none.rbcases").string(), "points.json", "vehicle.toml").exit_code, 5);

  std::string vehicle = kVehicle;
  write_text(folder / "unknown.toml", vehicle + "colour = 3\n");
  const ProgramRun unknown = classify(learnt_base(), "points.json", "unknown.toml");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("colour"), std::string::npos);

  // A pair's vehicle file has no section [sensor]; that the base is a laser's says more.
  write_text(folder / "pair.json", R"({"format": "raybundle stereo points", "version": 1})");
  write_text(folder / "pair.toml", vehicle.substr(0, vehicle.find("[sensor]")));
  const ProgramRun pair = classify(learnt_base(), "pair.json", "pair.toml");
  EXPECT_EQ(pair.exit_code, 2);
  EXPECT_NE(pair.err.find("holds points of stereo, but the base was learnt for structured-light"), std::string::npos)
      << pair.err;

  const ProgramRun incomplete = raybundle_program({"occupancy", "classify", learnt_base(), "points.json"});
  EXPECT_EQ(incomplete.exit_code, 2);
  EXPECT_NE(incomplete.err.find("raybundle occupancy classify --help"), std::string::npos) << incomplete.err;

  const auto with = [&](const std::string& key, const std::string& line) {
    std::string text = kVehicle;
    const std::size_t at = text.find(key + " = ");
    text.replace(at, text.find('\n', at) - at, line);
    write_text(folder / "other.toml", text);
    const ProgramRun run = classify(learnt_base(), "points.json", "other.toml");
    EXPECT_EQ(run.exit_code, 2) << run.err;
    return run.err;
  };
  EXPECT_NE(with("rows", "rows = 11.5").find("whole number"), std::string::npos);
  EXPECT_NE(with("rows", "rows = 12").find("11 rows"), std::string::npos);
  EXPECT_NE(with("critical_m", "critcal_m = 0.2").find("needs a field 'critical_m'; it has 'critcal_m'"),
            std::string::npos);

  const auto layout = [&](const std::string& line) {
    return with("out_of_position_m", "out_of_position_m = 0.40\n" + line);
  };
  EXPECT_NE(layout("track_m = -5").find("must not be below 0"), std::string::npos);
  EXPECT_NE(layout("lift_m = 1e9").find("no cabin is so large"), std::string::npos);
  EXPECT_NE(layout("most_recline_rad = 40").find("give radians"), std::string::npos);

  for (const std::string place : {"translation_m", "viewpoint_m"}) {
    EXPECT_NE(with(place, place + " = [30, 40, 0]").find(place + " is 50 m long, and no cabin is so large"),
              std::string::npos);
  }

  const std::string fixture = "out_of_position_m = 0.40\n[[fixture]]\nlow_m = [0.7, 0.2, 0.4]\n";
  EXPECT_NE(with("out_of_position_m", fixture).find("[[fixture]] needs a field 'high_m'"), std::string::npos);
  EXPECT_NE(with("out_of_position_m", fixture + "high_m = [0.8, 0.3, 0.3]").find("must lie below high_m"),
            std::string::npos);
  const std::string wide = "out_of_position_m = 0.40\n[[fixture]]\nlow_m = [0.07, 0.2, 0.4]\nhigh_m = [0.8, 0.3, 0.5]";
  EXPECT_NE(with("out_of_position_m", wide).find("must not leave the critical zone"), std::string::npos);

  write_text(folder / "broken.json", "{\"format\": \"raybundle laser points\"");
  const ProgramRun broken = classify(learnt_base(), "broken.json", "vehicle.toml");
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_EQ(broken.err.find("json.exception"), std::string::npos) << broken.err;
}

// What would fail after minutes of simulated scenes is said before them.
TEST(Occupancy, LearningChecksBeforeItWorks) {
  const auto refuses = [](std::vector<std::string> more, int exit_code, const std::string& said) {
    std::vector<std::string> words{"occupancy", "learn"};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = raybundle_program(words);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
  };
  const fs::path folder = fresh_folder();
  const std::string base = (folder / "seats.rbcases").string();
  refuses({"-o", folder.string()}, 5, "it is a folder");
  refuses({"-o", (folder / "none/seats.rbcases").string()}, 5, "there is no folder");
  refuses({"--scenes", "400", "-o", base}, 3, "take more --scenes");
  refuses({"--seed", "-1", "-o", base}, 2, "--seed");
  refuses({"--sensor", "stereo", "--beams", "11x11", "-o", base}, 2, "--beams");
}

// Frames are taken in the order given, those of a folder or pattern in that of their numbers.
TEST(Occupancy, TakesFoldersAndPatterns) {
  const fs::path folder = fresh_folder();
  write_text(folder / "vehicle.toml", kVehicle);
  fs::create_directories(folder / "points");
  for (const int frame : {2, 10, 1}) {
    write_text(folder / "points" / (std::to_string(frame) + ".json"), points_text(CabinClass::kEmpty, 5));
  }
  const auto files = [&](const std::string& points) {
    const ProgramRun run = raybundle_program(
        {"occupancy", "classify", learnt_base(), points, "--vehicle", (folder / "vehicle.toml").string(), "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const auto json = nlohmann::json::parse(run.out);
    std::string names;
    for (const auto& frame : json["frames"]) {
      names += fs::path(frame["file"].get<std::string>()).stem().string() + " ";
    }
    return names;
  };
  EXPECT_EQ(files((folder / "points").string()), "1 2 10 ");
  EXPECT_EQ(files((folder / "points").string() + "/*.json"), "1 2 10 ");
}

}  // namespace
}  // namespace raybundle::testing
