// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
// The files of `reconstruct stereo`, and what it says of its input.
#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "browser.hpp"
#include "program.hpp"
#include "raybundle/io/calibration_file.hpp"
#include "stereo_flags.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

TEST(ReconstructStereo, WritesWhatItSaysForARealFisheyePair) {
  RAYBUNDLE_NEEDS_DATA("sourishg_fisheye_stereo/imgs");
  const fs::path folder = fresh_folder();
  const std::string images = real_data("sourishg_fisheye_stereo/imgs").string() + "/";
  calibrate(folder, {"--target", "chessboard:9x6:24.23mm", "--camera", "left=" + images + "left1?.jpg", "--camera",
                     "right=" + images + "right1?.jpg", "--model", "kannala_brandt"});
  const ProgramRun run =
      raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(), images + "left3.jpg",
                         images + "right3.jpg", "-o", (folder / "points").string(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json, json_of(folder / "points" / "left3.json"));
  EXPECT_EQ(json.at("rectification").at("projection"), "equirectangular");
  EXPECT_GT(json.at("rectification").at("kept").at("left"), 0.95);
  const cv::Mat disparity = cv::imread((folder / "points" / "left3_disparity.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat depth = cv::imread((folder / "points" / "left3_depth.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(disparity.type(), CV_16U);
  EXPECT_EQ(disparity.size(), depth.size());
  EXPECT_GT(cv::countNonZero(disparity), 50000);
  EXPECT_LE(cv::countNonZero(depth), json.at("points").get<int>());
}

// Calibrates a pair of cameras by their first nine images of the board; the folder holds out/calibration.json.
fs::path calibrated_pairs(const std::string& images) {
  const fs::path folder = fresh_folder();
  calibrate(folder, {"--target", "chessboard:9x6:25mm", "--camera", "left=" + images + "left0?.jpg", "--camera",
                     "right=" + images + "right0?.jpg", "--model", "brown_conrady"});
  return folder;
}

// Reconstructs pairs of its images by that calibration.
ProgramRun reconstruct_pairs(const fs::path& folder, const std::string& left, const std::string& right,
                             const std::vector<std::string>& flags) {
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  std::vector<std::string> words{"reconstruct",
                                 "stereo",
                                 (folder / "out" / "calibration.json").string(),
                                 images + left,
                                 images + right,
                                 "-o",
                                 (folder / "points").string()};
  words.insert(words.end(), flags.begin(), flags.end());
  return raybundle_program(words);
}

// Images of two rooms: what little matches is chance, and the gate has to say so.
TEST(ReconstructStereo, FailsTheGateForImagesThatHaveNothingInCommon) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  RAYBUNDLE_NEEDS_DATA("boofcv_stereo/Bumblebee2_Chess");
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  const std::string other = real_data("boofcv_stereo/Bumblebee2_Chess").string() + "/right01.jpg";
  const fs::path folder = calibrated_pairs(images);
  const auto run = [&](const std::string& right, const std::string& out) {
    return raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(),
                              images + "left01.jpg", right, "-o", (folder / out).string()});
  };
  EXPECT_EQ(run(images + "right01.jpg", "related").exit_code, 0);
  const ProgramRun unrelated = run(other, "unrelated");
  EXPECT_EQ(unrelated.exit_code, 1);
  EXPECT_NE(unrelated.err.find("of one moment"), std::string::npos) << unrelated.err;
}

// A camera that sees nothing, exactly black or with the sensor's noise: nothing of it counts as matched, and it is
// named.
TEST(ReconstructStereo, FailsTheGateForACoveredCamera) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  const fs::path folder = calibrated_pairs(images);
  const std::string black = (folder / "black01.png").string(), noise = (folder / "noise01.png").string();
  cv::Mat grey(480, 640, CV_8U, cv::Scalar(0));
  cv::imwrite(black, grey);
  cv::randn(grey, 252.0, 2.0);
  cv::imwrite(noise, grey);
  const auto run = [&](const std::string& left, const std::string& right) {
    return raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(), left, right,
                              "-o", (folder / "points").string(), "--json"});
  };
  for (const auto& [left, right] :
       {std::pair(black, noise), std::pair(images + "left01.jpg", black), std::pair(noise, images + "right01.jpg")}) {
    const ProgramRun blank = run(left, right);
    EXPECT_EQ(blank.exit_code, 1);
    EXPECT_EQ(nlohmann::json::parse(blank.out).at("state"), "DEGRADED");
    EXPECT_NE(blank.err.find("01.png shows nothing"), std::string::npos) << blank.err;
    EXPECT_EQ(blank.err.find("exchange"), std::string::npos) << blank.err;
    EXPECT_EQ(blank.err.find("01.jpg shows nothing"), std::string::npos) << blank.err;
  }
}

// Some of what is exchanged matches by chance, more than the gate asks for.
TEST(ReconstructStereo, SaysThatLeftAndRightAreExchanged) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path folder = calibrated_pairs(real_data("opencv_stereo_chess").string() + "/");
  const auto run = [&](const char* left, const char* right) {
    return reconstruct_pairs(folder, left, right, {"--least-matched", "1"});
  };
  const ProgramRun straight = run("left0[35].jpg", "right0[35].jpg"),
                   exchanged = run("right0[35].jpg", "left0[35].jpg");
  EXPECT_EQ(straight.exit_code, 0) << straight.err;
  EXPECT_EQ(exchanged.exit_code, 1);
  EXPECT_NE(exchanged.err.find("2 of 2 pairs fit the other way round"), std::string::npos) << exchanged.err;
}

TEST(ReconstructStereo, NamesImagesThatAreNoPairs) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const fs::path folder = calibrated_pairs(real_data("opencv_stereo_chess").string() + "/");
  const auto run = [&](const char* left, const char* right) {
    return reconstruct_pairs(folder, left, right, {"--width", "99"});
  };
  const ProgramRun few = run("left0[12].jpg", "right0[1-3].jpg");
  EXPECT_NE(few.err.find("1 of 3 right images have no left one"), std::string::npos) << few.err;
  const ProgramRun other = run("left01.jpg", "right02.jpg");
  EXPECT_NE(other.err.find("their numbers differ"), std::string::npos) << other.err;
  EXPECT_EQ(run("left01.jpg", "right01.jpg").err.find("their numbers differ"), std::string::npos);
}

// A folder of images as people have them: with a note in it, and one image from somewhere else.
TEST(ReconstructStereo, TakesTheImagesOfFolders) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  const fs::path folder = calibrated_pairs(images);
  for (const std::string side : {"left", "right"}) {
    fs::create_directory(folder / side);
    for (const char* number : {"01", "02"}) {
      fs::copy_file(images + side + number + ".jpg", folder / side / (side + number + ".jpg"));
    }
    write_text(folder / side / "notes_03.txt", "taken in the morning");
    cv::imwrite((folder / side / (side + "03.jpg")).string(), cv::Mat(48, 64, CV_8U, cv::Scalar(90)));
  }
  const auto run = [&](const std::string& left, const std::string& out) {
    return raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(), left,
                              (folder / "right").string(), "-o", out});
  };
  const ProgramRun good = run((folder / "left").string(), (folder / "points").string());
  EXPECT_EQ(good.exit_code, 1);
  EXPECT_NE(good.err.find("left03.jpg: is 64x48"), std::string::npos) << good.err;
  EXPECT_NE(good.err.find("1 of 3 pairs could not be used"), std::string::npos) << good.err;
  for (const char* file : {"1.json", "2.json", "stereo.html"})
    EXPECT_TRUE(fs::exists(folder / "points" / file)) << file;
  EXPECT_FALSE(fs::exists(folder / "points" / "3.json"));
  const ProgramRun among = run((folder / "left").string(), (folder / "left").string());
  EXPECT_EQ(among.exit_code, 2);
  EXPECT_NE(among.err.find("lies in the output folder"), std::string::npos) << among.err;
  fs::create_directory(folder / "empty");
  const ProgramRun none = run((folder / "empty").string(), (folder / "points").string());
  EXPECT_EQ(none.exit_code, 5);
  EXPECT_NE(none.err.find("holds no images"), std::string::npos) << none.err;
  EXPECT_TRUE(fs::exists(folder / "points" / "stereo.html")) << "a run without a frame leaves the former one's page";
}

TEST(ReconstructStereo, ShowsASequenceInABrowser) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  if (browser_name().empty()) GTEST_SKIP() << "there is no Chromium on this machine";
  const std::string images = real_data("opencv_stereo_chess").string() + "/";
  const fs::path folder = calibrated_pairs(images);
  const ProgramRun run = raybundle_program({"reconstruct", "stereo", (folder / "out" / "calibration.json").string(),
                                            images + "left0[1-3].jpg", images + "right0[1-3].jpg", "-o",
                                            (folder / "points").string(), "--width", "320"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  Browser browser(folder / "profile");
  browser.open(folder / "points" / "stereo.html");
  EXPECT_EQ(browser.evaluate("frames.length"), 3);
  EXPECT_EQ(browser.evaluate("document.getElementById('disparity').naturalWidth"), 320);
  const std::string lit =
      "context.getImageData(0, 0, canvas.width, canvas.height).data.reduce((n, x, i) => n + (i % 4 === 3 && x > 0), 0)";
  EXPECT_GT(browser.evaluate(lit).get<int>(), 1000);  // points are drawn
  browser.evaluate("step(1)");
  EXPECT_EQ(browser.evaluate("document.getElementById('words').textContent.slice(0, 2)"), "2:");
  for (const std::string& request : browser.requests) {
    EXPECT_TRUE(request.starts_with("file:") || request.starts_with("data:")) << request;  // nothing from a network
  }
  EXPECT_TRUE(browser.errors.empty()) << browser.errors.front();
}

// Of this seed the fourth board stands in the beams: its white squares have no texture, but dots.
TEST(ReconstructStereo, LaserDotsFillWhatHasNoTexture) {
  const fs::path folder = fresh_folder();
  const std::string rig = RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_21mm_stereo_laser.toml";
  const ProgramRun simulated =
      raybundle_program({"simulate", rig, "--frames", "4", "--seed", "5", "-o", (folder / "sim").string()});
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const auto image = [&](const char* name) { return (folder / "sim/images" / name).string(); };
  const auto run = [&](std::vector<std::string> laser) {
    std::vector<std::string> words{"reconstruct",
                                   "stereo",
                                   (folder / "sim/truth/calibration.json").string(),
                                   image("left/003_off.png"),
                                   image("right/003_off.png"),
                                   "--near",
                                   "0.15",
                                   "--json",
                                   "-o",
                                   (folder / "points").string()};
    words.insert(words.end(), laser.begin(), laser.end());
    return raybundle_program(words);
  };
  const ProgramRun plain = run({}), fused = run({"--laser", image("left/003_on.png")});
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  ASSERT_EQ(fused.exit_code, 0) << fused.err;
  const nlohmann::json without = nlohmann::json::parse(plain.out), with = nlohmann::json::parse(fused.out);
  EXPECT_GT(with.at("laser").at("dots"), 50);
  EXPECT_GT(with.at("laser").at("filled"), 500);
  EXPECT_GT(with.at("points").get<int>(), without.at("points").get<int>() + 500);
  const ProgramRun small = run({"--laser", image("../truth/calibration.json")});
  EXPECT_EQ(small.exit_code, 5);
  const ProgramRun beyond = run({"--laser", image("left/003_on.png"), "--nearest", "3", "--farthest", "4"});
  ASSERT_EQ(beyond.exit_code, 0) << beyond.err;
  EXPECT_EQ(nlohmann::json::parse(beyond.out).at("laser").at("dots"), 0);
  EXPECT_NE(beyond.err.find("no dot got a place in 1 of 1 pairs"), std::string::npos) << beyond.err;
  EXPECT_EQ(fused.err.find("no dot got a place"), std::string::npos) << fused.err;
  EXPECT_EQ(run({"--farthest", "4"}).exit_code, 2);  // of a laser that is not used

  const auto video = [&](const char* from, const char* to) {
    const cv::Mat frame = cv::imread(image(from));
    const std::string path = (folder / to).string();
    cv::VideoWriter writer(path, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 10, frame.size());  // loses nothing
    for (int i = 0; i < 2; ++i) writer.write(frame);
    return path;
  };
  const std::string left = video("left/003_off.png", "left.avi"), right = video("right/003_off.png", "right.avi");
  const std::string lit = video("left/003_on.png", "lit.avi");
  const auto run_videos = [&](const std::string& laser) {
    return raybundle_program({"reconstruct", "stereo", (folder / "sim/truth/calibration.json").string(), left, right,
                              "--near", "0.15", "--laser", laser, "-o", (folder / "videos").string()});
  };
  const ProgramRun videos = run_videos(lit), mixed = run_videos(image("left/003_on.png"));
  ASSERT_EQ(videos.exit_code, 0) << videos.err;
  const nlohmann::json second = nlohmann::json::parse(text_of(folder / "videos" / "000001.json"));
  EXPECT_EQ(second.at("laser").at("filled"), with.at("laser").at("filled"));
  EXPECT_EQ(mixed.exit_code, 2);
  EXPECT_NE(mixed.err.find("is a video, and others are images"), std::string::npos) << mixed.err;
}

// The last rows of a large grid fill their place as the first ones do: there is room for all of its dots.
TEST(ReconstructStereo, HasRoomForTheDotsOfALargeLaser) {
  const fs::path folder = fresh_folder();
  const Camera camera = start_camera(*model_named("pinhole"), {330, 240}, 250.0);
  CalibrationFile file;
  file.calibration.cameras = {{"left", camera, {}}, {"right", camera, {}}};
  file.calibration.cameras[1].camera_from_rig.translation.x() = -0.1;
  LaserPattern laser{.grid = {33, 33}, .beams = {}, .grating = {}};
  for (int beam = 0; beam < laser.grid.size(); ++beam) {
    laser.beams.push_back({.row = laser.grid.row(beam), .column = laser.grid.column(beam), .line = {}});
  }
  file.calibration.laser = laser;
  write_calibration(folder / "calibration.json", file);

  apps::StereoSetup setup = apps::stereo_setup((folder / "calibration.json").string(), {}, true);
  const Rectification& pair = setup.matcher.rectification();
  const double across_px = pair.camera.size.width / 33.0, down_px = pair.camera.size.height / 33.0;
  std::vector<AnchorDot> dots;  // of a wall at 1 m
  for (int beam = 0; beam < laser.grid.size(); ++beam) {
    const double u = across_px * (laser.grid.column(beam) + 0.5), v = down_px * (laser.grid.row(beam) + 0.5);
    dots.push_back({u, v, disparity_from_distance(pair.camera, pair.baseline_m, u, 1.0), 0.1});
  }
  const cv::Mat grey(camera.size.height, camera.size.width, CV_8U, cv::Scalar(100));
  const GreyView flat{grey.ptr(), grey.cols, grey.rows, grey.cols};
  const StereoFrame frame = setup.matcher.process(flat, flat, dots);
  for (const double row : {1.0, 17.0, 32.0}) {  // between a row of dots and the next one
    const auto source = frame.fused.source.at(pair.camera.size.width / 2, static_cast<int>(row * down_px));
    EXPECT_EQ(static_cast<DisparitySource>(source), DisparitySource::kDots) << row;
  }
}

// Two equal cameras side by side, by Kalibr's file; the folder holds pair.json.
fs::path pair_of_long_lenses() {
  const fs::path folder = fresh_folder();
  const std::string lens =
      "  camera_model: pinhole\n  intrinsics: [1600, 1600, 449.5, 99.5]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [900, 200]\n";
  write_text(folder / "pair.yaml", "cam0:\n" + lens + "cam1:\n" + lens +
                                       "  T_cn_cnm1:\n  - [1, 0, 0, -0.2]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n"
                                       "  - [0, 0, 0, 1]\n");
  const ProgramRun run =
      raybundle_program({"import", (folder / "pair.yaml").string(), "-o", (folder / "pair.json").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return folder;
}

// 16 bits of 1/256 px end at 256 px: what was nearer was missing in the image.
TEST(ReconstructStereo, DisparitiesOfHundredsOfPixelsAreWrittenInCoarserSteps) {
  const fs::path folder = pair_of_long_lenses();
  cv::Mat left(200, 900, CV_8U), right(200, 900, CV_8U, cv::Scalar(0));
  cv::theRNG().state = 3;
  cv::randu(left, 0, 256);
  cv::GaussianBlur(left, left, {5, 5}, 1.0);
  left.colRange(320, 900).copyTo(right.colRange(0, 580));  // a wall at 1 m
  cv::imwrite((folder / "left1.png").string(), left);
  cv::imwrite((folder / "right1.png").string(), right);
  const ProgramRun run =
      raybundle_program({"reconstruct", "stereo", (folder / "pair.json").string(), (folder / "left1.png").string(),
                         (folder / "right1.png").string(), "-o", (folder / "points").string(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  const double step_px = json.at("disparity_step_px"), focal_px = json.at("rectification").at("focal_px");
  EXPECT_EQ(step_px, 1.0 / 128);
  const cv::Mat steps = cv::imread((folder / "points" / "left1_disparity.png").string(), cv::IMREAD_UNCHANGED);
  const cv::Mat matched = steps > 0;
  EXPECT_GT(cv::countNonZero(matched), 50000);
  EXPECT_NEAR(step_px * cv::mean(steps, matched)[0], 320 * focal_px / 1600, 0.5);
}

// Of two moments one image each can be read: what is left of both cameras is no pair.
TEST(ReconstructStereo, DoesNotPairWhatIsLeftOfTwoMoments) {
  const fs::path folder = pair_of_long_lenses();
  cv::Mat image(200, 900, CV_8U);
  cv::theRNG().state = 4;
  for (const std::string side : {"left", "right"}) {
    fs::create_directory(folder / side);
    const bool is_left = side == "left";
    cv::randu(image, 0, 256);
    cv::imwrite((folder / side / (is_left ? "01.png" : "02.png")).string(), image);
    write_text(folder / side / (is_left ? "02.png" : "01.png"), "");
  }
  const ProgramRun run =
      raybundle_program({"reconstruct", "stereo", (folder / "pair.json").string(), (folder / "left").string(),
                         (folder / "right").string(), "-o", (folder / "points").string()});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("02.png: "), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder / "points" / "01.json"));
}

TEST(ReconstructStereo, TheCameraThatIsNotNamedIsTheOther) {
  const fs::path folder = pair_of_long_lenses();
  const auto run = [&](const std::vector<std::string>& flags) {
    std::vector<std::string> words{"export", (folder / "pair.json").string(), "--rectification",
                                   (folder / "maps").string()};
    words.insert(words.end(), flags.begin(), flags.end());
    return raybundle_program(words);
  };
  const ProgramRun right = run({"--right", "cam1"}), exchanged = run({"--left", "cam1"});
  EXPECT_EQ(right.exit_code, 0) << right.err;
  EXPECT_NE(exchanged.err.find("swap the two: --left cam0 --right cam1"), std::string::npos) << exchanged.err;
  const ProgramRun same = run({"--left", "cam1", "--right", "cam1"});
  EXPECT_EQ(same.exit_code, 2);
  EXPECT_NE(same.err.find("--left and --right are both 'cam1'"), std::string::npos) << same.err;
}

TEST(ReconstructStereo, SaysWhatIsWrong) {
  const fs::path folder = fresh_folder();
  const ProgramRun missing =
      raybundle_program({"reconstruct", "stereo", (folder / "none.json").string(), "a.png", "b.png", "-o", "x"});
  EXPECT_EQ(missing.exit_code, 5);
  EXPECT_NE(missing.err.find("a.png"), std::string::npos) << missing.err;
}

}  // namespace
}  // namespace raybundle::testing
