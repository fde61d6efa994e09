// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// A pair of cameras in a car, as whoever installs it runs it: simulated images, `reconstruct stereo`, `occupancy
// classify`, and its page in a browser.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "browser.hpp"
#include "occupancy_chain.hpp"
#include "occupancy_evaluation.hpp"
#include "occupancy_learning.hpp"
#include "program.hpp"
#include "raybundle/occupancy/case_base_file.hpp"
#include "raybundle/occupancy/seat.hpp"
#include "stereo_cabin.hpp"
#include "stereo_flags.hpp"
#include "stereo_scan.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using apps::SensorKind;

constexpr int kScenesOfAClass = 4, kFrames = 4;

// A base of few scenes, all of which vote: enough to say something, not to be right.
const std::string& learnt_base() {
  static const std::string path = [] {
    LabelledCases cases{.attribute_set = std::string(kBoxes.name),
                        .situations = apps::cabin_situations(),
                        .group_names = apps::cabin_groups(),
                        .attributes = Eigen::MatrixXd(kBoxes.size, kScenesOfAClass * kCabinClasses),
                        .classes = {},
                        .actions = {}};
    for (int i = 0; i < kScenesOfAClass * kCabinClasses; ++i) {
      const CockpitRequest cockpit{CockpitGenerator::kTraining, 100u + static_cast<std::uint64_t>(i),
                                   static_cast<CabinClass>(i % kCabinClasses), 0.0};
      const apps::MeasuredScene scene = apps::ChainSource({SensorKind::kStereo, cockpit, {}, {128, 128}}).at(0.0);
      cases.attributes.col(i) = kBoxes.attributes(scene.layout, apps::seat_pose(scene.truth.seat), scene.scan());
      cases.classes.push_back(static_cast<std::uint8_t>(scene.truth.seat_class));
      cases.actions.push_back(scene.truth.decision == CabinDecision::kFire ? AirbagAction::kFire
                                                                           : AirbagAction::kNoFire);
    }
    const std::string bytes = bytes_from_case_base(learn(cases, {.neighbours = 3, .steps = 100}));
    const fs::path base = fresh_folder() / "seats.rbcases";
    write_text(base, bytes);
    return base.string();
  }();
  return path;
}

// Images of one cabin, and the points of them.
struct Cabin {
  fs::path folder = fresh_folder();

  Cabin(const std::string& seat_class, int size_px, int frames = kFrames) {
    const ProgramRun simulated = raybundle_program(
        {"simulate-cockpit", "--sensor", "stereo", "--class", seat_class, "--scenes", "1", "--frames",
         std::to_string(frames), "--size", std::to_string(size_px), "--seed", "21", "-o", (folder / "sim").string()});
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    const ProgramRun points = raybundle_program(
        {"reconstruct", "stereo", (folder / "sim/calibration.json").string(), (folder / "sim/*_left.png").string(),
         (folder / "sim/*_right.png").string(), "--near", "0.25", "-o", (folder / "points").string()});
    EXPECT_EQ(points.exit_code, 0) << points.err;
  }
  std::string vehicle() const { return (folder / "sim/00000_vehicle.toml").string(); }
  std::string points() const { return (folder / "points").string(); }
  ProgramRun classify(const std::string& points, std::vector<std::string> more = {}) const {
    std::vector<std::string> words{"occupancy", "classify", learnt_base(), points, "--vehicle", vehicle()};
    words.insert(words.end(), more.begin(), more.end());
    return raybundle_program(words);
  }
  nlohmann::json frames(const std::string& points) const {
    const ProgramRun run = classify(points, {"--json"});
    EXPECT_LE(run.exit_code, 1) << run.err;  // 1: votes of so few scenes may agree on nothing
    return run.exit_code <= 1 ? nlohmann::json::parse(run.out).at("frames") : nlohmann::json::array();
  }
};

// Through files the monitor is told, to the bit, what the runtime's points of the same images tell it.
TEST(StereoOccupancy, FilesTellWhatTheRuntimeMeasured) {
  const Cabin cabin("passenger", 128);
  const nlohmann::json frames = cabin.frames(cabin.points());
  ASSERT_EQ(frames.size(), kFrames);
  apps::StereoFlags flags;
  flags.near_m = 0.25;
  apps::StereoSetup setup = apps::stereo_setup((cabin.folder / "sim/calibration.json").string(), flags, false);
  const apps::StereoCabin car = apps::read_stereo_cabin(cabin.vehicle());
  const Rectification& pair = setup.matcher.rectification();
  apps::StereoScan scan(pair.camera, car.vehicle_from_rig * pair.rig_from_rectified);
  OccupancyMonitor monitor(car.layout, case_base_from_bytes(text_of(learnt_base()), learnt_base()), scan.rays(),
                           apps::monitor_options_of(SensorKind::kStereo));
  for (int i = 0; i < kFrames; ++i) {
    const auto image = [&](const char* side) {
      return cv::imread((cabin.folder / "sim" / fmt::format("00000_{:03}_{}.png", i, side)).string(),
                        cv::IMREAD_GRAYSCALE);
    };
    const cv::Mat left = image("left"), right = image("right");
    const Occupancy answer = monitor.process(
        scan.of(setup.matcher.process({left.data, left.cols, left.rows, static_cast<std::ptrdiff_t>(left.step)},
                                      {right.data, right.cols, right.rows, static_cast<std::ptrdiff_t>(right.step)})));
    const nlohmann::json& told = frames.at(static_cast<std::size_t>(i));
    EXPECT_EQ(told.at("confidence"), answer.confidence) << i;
    EXPECT_EQ(told.at("rays_through_zones"), answer.free_rays) << i;
    EXPECT_EQ(told.at("moving"), answer.moving) << i;
    EXPECT_EQ(told.at("points_in_outer_zone"), answer.zones.out_of_position) << i;
    EXPECT_TRUE(told.at("cabin").contains("head")) << i;
  }
}

// Images of other sizes are thinned to the rays that were learnt with: what crosses the zones and what moves is the
// same, to what sharper images see more.
TEST(StereoOccupancy, TakesImagesOfAnySize) {
  const Cabin small("empty", 128), large("empty", 480);
  const nlohmann::json a = small.frames(small.points()).back(), b = large.frames(large.points()).back();
  EXPECT_LT(b.at("moving"), 0.06);  // at rest; 0.10 is where something lives
  const double rays = a.at("rays_through_zones"), other_rays = b.at("rays_through_zones");
  EXPECT_NEAR(other_rays, rays, 0.15 * rays);
  EXPECT_NE(b.at("state"), "INVALID");
  EXPECT_NE(b.at("airbag"), "fire");
}

// What a run leaves in its folder is of this run, so that the next verb may take the folder.
TEST(StereoOccupancy, FoldersHoldOneRun) {
  const Cabin cabin("empty", 128, 3);
  write_text(cabin.folder / "points/mine.json", "{}");
  const auto image = [&](const char* side) { return (cabin.folder / "sim/00000_00[01]_").string() + side + ".png"; };
  const ProgramRun points =
      raybundle_program({"reconstruct", "stereo", (cabin.folder / "sim/calibration.json").string(), image("left"),
                         image("right"), "-o", cabin.points()});
  ASSERT_EQ(points.exit_code, 0) << points.err;
  EXPECT_TRUE(fs::exists(cabin.folder / "points/1.ply"));
  for (const char* ending : {".json", ".ply", "_left.png", "_right.png", "_disparity.png", "_depth.png"}) {
    EXPECT_FALSE(fs::exists(cabin.folder / "points" / (std::string("2") + ending))) << ending;
  }
  EXPECT_TRUE(fs::exists(cabin.folder / "points/mine.json"));
  const ProgramRun simulated = raybundle_program({"simulate-cockpit", "--sensor", "stereo", "--scenes", "1", "--frames",
                                                  "1", "--size", "64", "-o", (cabin.folder / "sim").string()});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  EXPECT_TRUE(fs::exists(cabin.folder / "sim/00000_000_left.png"));
  EXPECT_FALSE(fs::exists(cabin.folder / "sim/00000_001_left.png"));
}

// The other sensor's flags change nothing, and a seed must be one.
TEST(SimulateCockpit, RefusesFlagsThatWouldDoNothing) {
  const std::string folder = (fresh_folder() / "sim").string();
  const auto refuses = [&](const std::string& sensor, const std::string& flag, const std::string& value) {
    const ProgramRun run = raybundle_program({"simulate-cockpit", "--sensor", sensor, flag, value, "-o", folder});
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(flag), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(folder));
  };
  refuses("stereo", "--rows", "9");
  refuses("structured-light", "--size", "64");
  refuses("stereo", "--seed", "-1");
  refuses("stereo", "--seed", "18446744073709551615");
}

TEST(StereoOccupancy, ThePageShowsTheDecisionAndPlays) {
  if (browser_name().empty()) GTEST_SKIP() << "there is no Chromium on this machine to open the page with";
  const Cabin cabin("rear_baby_seat", 128);
  const fs::path page = cabin.folder / "seats.html";
  const ProgramRun run = cabin.classify(cabin.points() + "/*.json", {"--page", page.string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  Browser browser(cabin.folder / "profile");
  browser.open(page);
  const auto value = [&](const std::string& expression) { return browser.evaluate(expression); };
  EXPECT_EQ(value("frames.length"), kFrames);
  EXPECT_EQ(value("part('airbag').textContent"), value("frames[0].answer.airbag"));
  EXPECT_GT(value("part('reasons').rows.length").get<int>(), 5);
  EXPECT_FALSE(value("part('decision').hidden").get<bool>());
  for (const char* image : {"left", "right", "disparity"}) {
    EXPECT_GT(value(fmt::format("part('{0}').decode().then(() => part('{0}').naturalWidth)", image)).get<int>(), 100);
  }
  EXPECT_EQ(value("frames[0].drawn.length"), 7);  // two zones, five boxes; nobody has a head
  browser.click("#play");
  const char* const after_a_while = R"(new Promise(done => {
    const look = looks => part('at').value !== '0' || looks === 0 ? done(part('at').value)
                                                                   : setTimeout(() => look(looks - 1), 50);
    look(600);
  }))";  // at most half a minute, on a machine with much else to do
  EXPECT_NE(value(after_a_while), "0");
  EXPECT_TRUE(browser.errors.empty()) << browser.errors.front();
}

TEST(StereoOccupancy, SaysWhatIsWrongWithItsInput) {
  const Cabin cabin("empty", 128, 1);
  const fs::path points = cabin.folder / "points", bad = cabin.folder / "bad";
  const std::string json = text_of(points / "00000_000_left.json"), ply = text_of(points / "00000_000_left.ply");
  const auto refuses = [&](const std::string& frame, const std::string& cloud, const std::string& said) {
    write_text(bad / "1.json", frame);
    write_text(bad / "1.ply", cloud);
    const ProgramRun run = cabin.classify(bad.string());
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(said), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("json.exception"), std::string::npos) << run.err;
  };
  fs::create_directories(bad);
  refuses(json.substr(0, json.size() / 2), ply, "not all of it");
  refuses(json, ply.substr(0, ply.size() - 5), "not all of it");
  refuses(R"({"format": "raybundle laser points", "version": 1})", ply, "holds points of structured-light");
  refuses(R"({"format": "raybundle stereo points", "version": 1})", ply, "lacks something");
  refuses("[]", ply, "is not what");
  const ProgramRun none = cabin.classify((cabin.folder / "none/*.json").string());
  EXPECT_EQ(none.exit_code, 5);
  const ProgramRun page = cabin.classify(points.string(), {"--page", (cabin.folder / "no/seats.html").string()});
  EXPECT_EQ(page.exit_code, 5);
  EXPECT_NE(page.err.find("--page"), std::string::npos) << page.err;
}

}  // namespace
}  // namespace raybundle::testing
