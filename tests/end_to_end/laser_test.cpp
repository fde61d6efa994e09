// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "program.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

const std::string kRig = RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml";

ProgramRun simulate(const fs::path& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"simulate", kRig, "-o", folder.string()});
  return raybundle_program(arguments);
}

/// Distances [m] at z = 1 m of the beams from the true ones; of an unknown beam infinite.
std::vector<double> distances_at_1m(const nlohmann::json& calibration, const nlohmann::json& truth) {
  const auto place = [](const nlohmann::json& beam) {
    const nlohmann::json &p = beam["point_m"], &d = beam["direction"];
    const double along = (1.0 - p[2].get<double>()) / d[2].get<double>();
    return std::pair(p[0].get<double>() + along * d[0].get<double>(), p[1].get<double>() + along * d[1].get<double>());
  };
  std::map<std::pair<int, int>, nlohmann::json> known;
  for (const nlohmann::json& beam : truth["laser"]["beams"]) known[{beam["row"], beam["column"]}] = beam;
  std::vector<double> distances;
  for (const nlohmann::json& beam : calibration["laser"]["beams"]) {
    const auto [x, y] = place(beam);
    const auto found = known.find({beam["row"], beam["column"]});
    const auto [u, v] = found == known.end() ? std::pair<double, double>(INFINITY, INFINITY) : place(found->second);
    distances.push_back(std::hypot(x - u, y - v));
  }
  std::ranges::sort(distances);
  return distances;
}

// With dots of 0.1 px and 15 of them on a beam, half of the beams are known to a millimetre at 1 m; a beam with a wrong
// label would be off by a step of the grid, 15 cm.
TEST(Laser, ObservationsGiveTheBeamsAndHeldOutBoardsConfirmThem) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "60", "--seed", "7", "--no-images"}).exit_code, 0);
  ASSERT_EQ(simulate(folder / "other", {"--frames", "20", "--seed", "8", "--no-images"}).exit_code, 0);
  const nlohmann::json report = calibrate(folder, {"--observations", (folder / "sim/observations.json").string()});
  EXPECT_LT(report["laser"]["drag_sigmas"].get<double>(), 4.0);
  EXPECT_GT(report["laser"]["parameters"].size(), 7u);
  const nlohmann::json calibration = json_of(folder / "out" / "calibration.json");
  const std::vector<double> distances = distances_at_1m(calibration, json_of(folder / "sim/truth/calibration.json"));
  ASSERT_GT(distances.size(), 110u);
  EXPECT_LT(distances[distances.size() / 2], 1e-3);
  EXPECT_LT(distances[distances.size() * 9 / 10], 5e-3);
  const nlohmann::json& middle = calibration["laser"]["beams"][distances.size() / 2];
  EXPECT_EQ(middle["covariance"].size(), 4u);
  EXPECT_NEAR(middle["depths"][2]["sigma_m"].get<double>(), 3e-3, 2e-3);  // z² sigma / (f b) over the root of the hits
  EXPECT_GT(calibration["laser"]["label_advice"]["single_candidate_share"].get<double>(), 0.9);

  const std::vector<std::string> held_out{"validate", (folder / "out/calibration.json").string(), "--observations",
                                          (folder / "other/observations.json").string(), "--json"};
  const ProgramRun run = raybundle_program(held_out);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json verdict = nlohmann::json::parse(run.out);
  EXPECT_GT(verdict["laser"]["explained"].get<int>(), verdict["laser"]["dots"].get<int>() * 98 / 100);
  EXPECT_LT(verdict["laser"]["rms_px"].get<double>(), 0.2);  // of dots of 0.1 px in u and in v
  std::vector<std::string> gated = held_out;
  gated.insert(gated.end(), {"--max-plane", "0.01"});
  EXPECT_EQ(raybundle_program(gated).exit_code, 1);

  nlohmann::json without_dots = json_of(folder / "other/observations.json");
  for (nlohmann::json& view : without_dots["views"]) view.erase("dots");
  write_text(folder / "without.json", without_dots.dump());
  const ProgramRun nothing =
      raybundle_program({"validate", (folder / "out/calibration.json").string(), "--observations",
                         (folder / "without.json").string(), "--max-plane", "5"});
  EXPECT_EQ(nothing.exit_code, 1) << "a gate with nothing to judge";
}

// The board is found with the laser off, the dots with it on; spots on edges of the print are given up.
// Ten kelvins move the wavelength by 2.8 nm of 830 nm, and points at 1 m by centimetres; five frames mend it.
TEST(Laser, AWarmerLaserIsRetunedFromFiveFrames) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "40", "--seed", "7", "--no-images"}).exit_code, 0);
  ASSERT_EQ(simulate(folder / "warm", {"--frames", "5", "--seed", "9", "--no-images", "--warmer", "10"}).exit_code, 0);
  calibrate(folder, {"--observations", (folder / "sim/observations.json").string()});
  const auto validate = [&](const std::string& calibration, std::vector<std::string> more) {
    more.insert(more.begin(), {"validate", (folder / calibration).string(), "--observations",
                               (folder / "warm/observations.json").string(), "--json"});
    const ProgramRun run = raybundle_program(more);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out)["laser"];
  };
  const nlohmann::json cold = validate("out/calibration.json", {"--retune", (folder / "warm.json").string()});
  EXPECT_TRUE(cold["wavelength"]["drifted"].get<bool>());
  EXPECT_NEAR(cold["wavelength"]["scale"].get<double>(), 1 + 2.8 / 830, 4e-4);  // a tenth of the drift, 1 K
  const nlohmann::json warm = validate("warm.json", {});
  EXPECT_FALSE(warm["wavelength"]["drifted"].get<bool>());
  EXPECT_GT(cold["plane_rms_mm"].get<double>(), 10.0);
  EXPECT_LT(warm["plane_rms_mm"].get<double>(), 5.0);
}

/// The rig of these tests with its projector turned by 0.3 degrees: half the distance between two beams at its rim.
fs::path turned_rig(const fs::path& folder) {
  std::string rig = text_of(kRig);
  const std::string turn = "turned_deg = [0.8, -1.5, 0.4]";
  EXPECT_NE(rig.find(turn), std::string::npos);
  rig.replace(rig.find(turn), turn.size(), "turned_deg = [0.8, -1.2, 0.4]");
  write_text(folder / "turned.toml", rig);
  return folder / "turned.toml";
}

/// sim/ and moved/, of the same boards, with the projector as it was and turned.
void simulate_before_and_after_a_turn(const fs::path& folder) {
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "40", "--seed", "7", "--no-images"}).exit_code, 0);
  ASSERT_EQ(raybundle_program({"simulate", turned_rig(folder).string(), "-o", (folder / "moved").string(), "--frames",
                               "40", "--seed", "7", "--no-images"})
                .exit_code,
            0);
}

TEST(Laser, AProjectorThatHasMovedIsToldFromAWarmerOne) {
  const fs::path folder = fresh_folder();
  simulate_before_and_after_a_turn(folder);
  calibrate(folder, {"--observations", (folder / "sim/observations.json").string()});
  const std::vector<std::string> held_out{"validate", (folder / "out/calibration.json").string(), "--observations",
                                          (folder / "moved/observations.json").string()};
  const ProgramRun run = raybundle_program(held_out);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.out.find("has the projector moved"), std::string::npos) << run.out;
  std::vector<std::string> retuned = held_out;
  retuned.insert(retuned.end(), {"--retune", (folder / "warm.json").string()});
  EXPECT_EQ(raybundle_program(retuned).exit_code, 3);
  EXPECT_FALSE(fs::exists(folder / "warm.json"));
}

/// The simulation's observations with the dots of another one, of the same boards, from some frame on.
nlohmann::json with_dots_of(nlohmann::json observations, const nlohmann::json& other, std::size_t first) {
  for (std::size_t v = first; v < observations["views"].size(); ++v) {
    observations["views"][v]["dots"] = other["views"][v]["dots"];
  }
  return observations;
}

TEST(Laser, AProjectorThatMovesOnTheWayIsNamedAndNotAveragedIn) {
  const fs::path folder = fresh_folder();
  simulate_before_and_after_a_turn(folder);
  const nlohmann::json before = json_of(folder / "sim/observations.json");
  const nlohmann::json after = json_of(folder / "moved/observations.json");
  write_text(folder / "last.json", with_dots_of(before, after, 36).dump());
  const nlohmann::json report = calibrate(folder, {"--observations", (folder / "last.json").string()});
  EXPECT_NE(report["warnings"].dump().find("(36, 37, 38, 39) lie on no beam"), std::string::npos) << report["warnings"];
  const std::vector<double> distances =
      distances_at_1m(json_of(folder / "out/calibration.json"), json_of(folder / "sim/truth/calibration.json"));
  EXPECT_LT(distances[distances.size() / 2], 1.5e-3);

  write_text(folder / "half.json", with_dots_of(before, after, 20).dump());
  const nlohmann::json half = calibrate(folder, {"--observations", (folder / "half.json").string()});
  EXPECT_NE(half["warnings"].dump().find("laser dots on boards lie on a beam"), std::string::npos) << half["warnings"];

  nlohmann::json swapped = before;
  for (nlohmann::json& view : swapped["views"]) {
    for (nlohmann::json& dot : view["dots"]) std::swap(dot[0], dot[1]);
  }
  write_text(folder / "swapped.json", swapped.dump());
  const nlohmann::json exchanged = calibrate(folder, {"--observations", (folder / "swapped.json").string()});
  EXPECT_NE(exchanged["warnings"].dump().find("the laser's beams could not be calibrated: only"), std::string::npos);
  EXPECT_FALSE(json_of(folder / "out/calibration.json").contains("laser"));
}

TEST(Laser, ImagesGiveTheBeams) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "40", "--seed", "7"}).exit_code, 0);
  const nlohmann::json report = calibrate(folder, {(folder / "sim/dataset.toml").string()});
  const nlohmann::json calibration = json_of(folder / "out" / "calibration.json");
  const std::vector<double> distances = distances_at_1m(calibration, json_of(folder / "sim/truth/calibration.json"));
  ASSERT_GT(distances.size(), 90u);
  EXPECT_LT(distances[distances.size() / 2], 1e-3);
  EXPECT_LT(distances.back(), 0.05);  // no label is wrong: a step of the grid is 15 cm
}

// Dots of an image of half the size are at half the pixels, and an image of other bits cannot be subtracted.
TEST(Laser, ImagesThatAreNoPairAreNamed) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "12", "--seed", "7"}).exit_code, 0);
  const fs::path images = folder / "sim/images/camera";
  const auto change = [&](const std::string& name, const std::function<void(cv::Mat&)>& how) {
    cv::Mat image = cv::imread((images / name).string(), cv::IMREAD_UNCHANGED);
    ASSERT_FALSE(image.empty()) << name;
    how(image);
    cv::imwrite((images / name).string(), image);
  };
  change("003_on.png", [](cv::Mat& image) { cv::resize(image, image, {}, 0.5, 0.5); });
  change("004_off.png", [](cv::Mat& image) {
    image.depth() == CV_8U ? image.convertTo(image, CV_16U, 257) : image.convertTo(image, CV_8U, 1.0 / 257);
  });
  const ProgramRun run = raybundle_program(
      {"detect", (folder / "sim/dataset.toml").string(), "-o", (folder / "observations.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("003_on.png: is "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("1 images with the laser off could not be subtracted"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("004_on.png: it has "), std::string::npos) << run.err;
}

// What a calibration knows of fewer beams never permits more power: those it does not know are there all the same.
TEST(EyeSafety, BeamsThatNothingDeterminedPermitNothing) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "60", "--seed", "7", "--no-images"}).exit_code, 0);
  calibrate(folder, {"--observations", (folder / "sim/observations.json").string()});
  nlohmann::json calibration = json_of(folder / "out/calibration.json");
  const auto judged = [&] {
    write_text(folder / "some.json", calibration.dump());
    const ProgramRun run = raybundle_program(
        {"eye-safety", "--edition", "1993", "--calibration", (folder / "some.json").string(), "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out);
  };
  const nlohmann::json all = judged();
  nlohmann::json& beams = calibration["laser"]["beams"];
  for (std::size_t i = 0; i < beams.size(); ++i) beams.erase(i);
  const nlohmann::json half = judged();
  EXPECT_EQ(half["beams_in_aperture"], all["beams_in_aperture"]);
  EXPECT_LT(half["permissible_total_mW"].get<double>(), all["permissible_total_mW"].get<double>());
  beams.erase(beams.begin() + 1, beams.end());
  for (const char* pitch : {"column_pitch", "row_pitch"}) {
    nlohmann::json& value = calibration["laser"]["grating"][pitch];
    value = 0.1 * value.get<double>();  // a grating whose beams lie close to each other
  }
  EXPECT_GT(judged()["beams_in_aperture"].get<int>(), 20);
}

// A click on a dot of another beam moves all labels with it; one that is nowhere near a dot is refused.
TEST(Laser, TheAnchorDecidesWhichBeamIsWhich) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(simulate(folder / "sim", {"--frames", "60", "--seed", "3", "--beams", "19x16", "--no-images"}).exit_code,
            0);
  const nlohmann::json exact = json_of(folder / "sim/truth/observations.json");
  const nlohmann::json& dot = exact["views"][4]["dots"][3];
  const std::string frame = exact["views"][4]["frame"];
  const auto anchored = [&](double u, int row, int column) {
    const std::string anchor = "camera/" + frame + ":" + std::to_string(u) + "," +
                               std::to_string(dot[1].get<double>()) + "=" + std::to_string(row) + "," +
                               std::to_string(column);
    return raybundle_program({"calibrate", "--observations", (folder / "sim/observations.json").string(), "--anchor",
                              anchor, "-o", (folder / "out").string()});
  };
  const ProgramRun right = anchored(dot[0].get<double>() + 1.0, dot[5], dot[6]);
  ASSERT_EQ(right.exit_code, 0) << right.err;
  EXPECT_LT(
      distances_at_1m(json_of(folder / "out/calibration.json"), json_of(folder / "sim/truth/calibration.json")).back(),
      0.05);
  EXPECT_EQ(anchored(1e4, dot[5], dot[6]).exit_code, 2);
  EXPECT_EQ(anchored(dot[0], 16, 0).exit_code, 2);
}

// The pixels of a video projector as beams whose labels are known. One row of the table is one dot.
struct ProjectorDot {
  int capture = 0, u = 0, v = 0;
  double x = 0.0, y = 0.0;
};

std::vector<ProjectorDot> projector_dots(const fs::path& path) {
  std::vector<ProjectorDot> dots;
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    ProjectorDot dot;
    const int fields = std::sscanf(line.c_str(), "%d,%d,%d,%lf,%lf", &dot.capture, &dot.u, &dot.v, &dot.x, &dot.y);
    if (fields == 5) dots.push_back(dot);
  }
  return dots;
}

/// The observations of some captures, with the projector's dots: those beside the board, too.
void write_captures(const fs::path& path, nlohmann::json observations, const std::vector<ProjectorDot>& dots,
                    const std::function<bool(const std::string&)>& wanted) {
  constexpr int kStep_px = 32;  // of the projector, between dots
  nlohmann::json views = nlohmann::json::array();
  for (nlohmann::json view : observations["views"]) {
    const std::string frame = view["frame"];
    if (!wanted(frame)) continue;
    view["dots"] = nlohmann::json::array();
    for (const ProjectorDot& dot : dots) {
      if (std::to_string(dot.capture) != frame) continue;
      view["dots"].push_back({dot.x, dot.y, 0.04, 0, 0.04, dot.v / kStep_px, dot.u / kStep_px, 0});
    }
    views.push_back(view);
  }
  observations["views"] = views;
  observations["laser"] = {{"rows", 40}, {"columns", 60}};
  write_text(path, observations.dump());
}

// Real light: four poses calibrated, the dots of the fifth predicted on its board, every pose left out in turn. A beam
// was met two or three times by the board; dots that are not on it count for nothing.
TEST(Laser, RealProjectorDotsAreWhereTheOtherPosesSay) {
  RAYBUNDLE_NEEDS_DATA("procam_virtual_dots");
  const fs::path data = real_data("procam_virtual_dots"), folder = fresh_folder();
  const ProgramRun detected =
      raybundle_program({"detect", "--target", "chessboard:9x7:20mm", "--camera",
                         "camera=" + (data / "white_capture_*.png").string(), "-o", (folder / "found.json").string()});
  ASSERT_EQ(detected.exit_code, 0) << detected.err;
  const nlohmann::json observations = json_of(folder / "found.json");
  const std::vector<ProjectorDot> dots = projector_dots(data / "virtual_dots.csv");
  for (const std::string left_out : observations["frames"]) {
    write_captures(folder / "four.json", observations, dots, [&](const auto& frame) { return frame != left_out; });
    write_captures(folder / "fifth.json", observations, dots, [&](const auto& frame) { return frame == left_out; });
    const nlohmann::json report =
        calibrate(folder, {"--observations", (folder / "four.json").string(), "--model", "brown_conrady"});
    EXPECT_GT(report["laser"]["dots_unlabelled"].get<int>(), 700) << "most of 1100 lie beside the board";
    const ProgramRun run = raybundle_program({"validate", (folder / "out/calibration.json").string(), "--observations",
                                              (folder / "fifth.json").string(), "--max-rms", "1", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json laser = nlohmann::json::parse(run.out)["laser"];
    EXPECT_GT(laser["explained"].get<int>(), 25) << left_out;
    EXPECT_LT(laser["median_px"].get<double>(), 0.5) << left_out;
  }
}

// A laser line's scanner: its images with the laser off calibrate the camera. Its own parameters took the centres of
// ellipses for those of circles, which is worth some tenths of a percent.
TEST(Laser, ImagesOfALineScannerWithTheLaserOffCalibrateItsCamera) {
  RAYBUNDLE_NEEDS_DATA("linelight_zhao");
  const nlohmann::json report =
      calibrate(fresh_folder(), {"--target", "circles:7x7:20mm", "--model", "brown_conrady", "--camera",
                                 "camera=" + (real_data("linelight_zhao") / "calib_picture/*.jpg").string()});
  const nlohmann::json& camera = camera_in(report, "camera");
  EXPECT_EQ(camera["views_used"], 12);
  EXPECT_LT(camera["rms_px"].get<double>(), 0.1);
  EXPECT_NEAR(camera["parameters"]["fx"].get<double>(), 1144.4, 0.005 * 1144.4);
}

}  // namespace
}  // namespace raybundle::testing
