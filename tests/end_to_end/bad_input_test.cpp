// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "program.hpp"
#include "raybundle/calibrate/calibrate.hpp"
#include "raybundle/io/observations_file.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kImages = "opencv_stereo_chess";

/// Each test spoils one thing in a folder that holds the results of an earlier run: these must survive.
class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(place / "out");
    for (const char* name : {"calibration.json", "report.json", "report.html"}) write_text(place / "out" / name, kOld);
  }

  void TearDown() override { fs::remove_all(place); }

  /// Runs `calibrate`, which must refuse in one line that holds `words`, and leave the folder as it was.
  void refuses(std::vector<std::string> arguments, int exit_code, const std::vector<std::string>& words) {
    arguments.insert(arguments.begin(), "calibrate");
    arguments.insert(arguments.end(), {"-o", (place / "out").string()});
    const ProgramRun run = raybundle_program(arguments);
    ASSERT_EQ(run.exit_code, exit_code) << run.err << run.out;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    EXPECT_TRUE(run.err.starts_with("raybundle: error: ")) << run.err;
    for (const std::string& word : words) EXPECT_THAT(run.err, HasSubstr(word));
    EXPECT_EQ(run.out, "");
    int files = 0;
    for (const auto& entry : fs::directory_iterator(place / "out")) {
      EXPECT_TRUE(text_of(entry.path()) == kOld) << entry.path() << " has changed";
      ++files;
    }
    EXPECT_EQ(files, 3) << "a file was left over or lost";
  }

  /// Refuses corners of a 7x5 board in files of ours.
  void refuses_corners(const std::string& file, const std::string& text, int exit_code,
                       const std::vector<std::string>& words) {
    write_text(place / file, text);
    refuses({"--observations", (place / file).string(), "--target", "chessboard:7x5:40mm", "--image-size", "a=640x480",
             "--model", "pinhole"},
            exit_code, words);
  }

  /// Copies the first `count` left images.
  void copy_images(int count) {
    for (int i = 1; i <= count; ++i) {
      const std::string name = fmt::format("left{:02}.jpg", i);
      fs::copy_file(real_data(kImages) / name, place / name);
    }
  }

  std::vector<std::string> images(const std::string& board = "chessboard:9x6:25mm") {
    return {"--target", board, "--camera", "left=" + (place / "left*.jpg").string(), "--model", "brown_conrady"};
  }

  static constexpr const char* kOld = "{\"an\": \"earlier result\"}";
  fs::path place = fresh_folder();
};

TEST_F(BadInput, NoImageMatches) { refuses(images(), 5, {"no image matches", "left*.jpg"}); }

TEST_F(BadInput, TruncatedAndUnreadableImagesAmongGoodOnesAreNamedAndLeftOut) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(8);
  const std::string whole = text_of(place / "left03.jpg");
  write_text(place / "left03.jpg", whole.substr(0, whole.size() / 2));
  write_text(place / "left04.jpg", "this is not an image");
  const nlohmann::json report = calibrate(place, images());
  ASSERT_TRUE(report.contains("cameras"));
  EXPECT_EQ(camera_in(report, "left").at("views_used"), 6);
  std::string reasons;
  for (const auto& entry : report.at("set_aside")) {
    reasons += entry.at("image").get<std::string>() + ": " + entry.at("reason").get<std::string>() + "\n";
  }
  EXPECT_THAT(reasons, HasSubstr("left03.jpg: the image file is truncated"));
  EXPECT_THAT(reasons, HasSubstr("left04.jpg: not an image"));
}

// Without a number of its own, such a file once took the numbers of the images away, and with them the rig.
TEST_F(BadInput, AFileThatIsNoImageCostsTheImagesNoNumber) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(8);
  for (int i = 1; i <= 8; ++i) {
    const std::string name = fmt::format("right{:02}.jpg", i);
    fs::copy_file(real_data(kImages) / name, place / name);
  }
  write_text(place / "left_readme.txt", "taken on a Sunday");
  const std::vector<std::string> rest{"--target", "chessboard:9x6:25mm", "--model", "brown_conrady"};
  std::vector<std::string> pair{"--camera", "left=" + (place / "left*").string(), "--camera",
                                "right=" + (place / "right*").string()};
  pair.insert(pair.end(), rest.begin(), rest.end());
  const nlohmann::json report = calibrate(place, pair);
  ASSERT_EQ(report.at("cameras").size(), 2U);
  EXPECT_EQ(camera_in(report, "left").at("views_used"), 8);
  EXPECT_THAT(report.at("set_aside").dump(), HasSubstr("left_readme.txt\",\"reason\":\"not an image"));

  for (const char* name : {"calibration.json", "report.json", "report.html"}) write_text(place / "out" / name, kOld);
  std::vector<std::string> mixed{"--camera", "left=" + (place / "*").string()};
  mixed.insert(mixed.end(), rest.begin(), rest.end());
  refuses(mixed, 2, {"left01.jpg", "right01.jpg", "would both be frame 1"});
}

TEST_F(BadInput, AllImagesUnreadable) {
  for (int i = 1; i < 4; ++i) write_text(place / fmt::format("left{}.jpg", i), "this is not an image");
  refuses(images(), 3, {"left1.jpg", "not an image"});
}

TEST_F(BadInput, MixedImageSizes) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(8);
  for (const char* name : {"left05.jpg", "left06.jpg", "left07.jpg", "left08.jpg"}) {
    cv::Mat half;
    cv::resize(cv::imread((place / name).string()), half, {}, 0.5, 0.5);
    cv::imwrite((place / name).string(), half);
  }
  refuses(images(), 2, {"different sizes", "640x480", "320x240", "left01.jpg", "left05.jpg"});
}

TEST_F(BadInput, AnImageOfAnotherSizeCostsOnlyItself) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(8);
  cv::Mat half;
  cv::resize(cv::imread((place / "left04.jpg").string()), half, {}, 0.5, 0.5);
  cv::imwrite((place / "left04.jpg").string(), half);
  const nlohmann::json report = calibrate(place, images());
  EXPECT_EQ(camera_in(report, "left").at("views_used"), 7);
  EXPECT_THAT(report.at("set_aside").dump(),
              HasSubstr("left04.jpg\",\"reason\":\"is 320x240, but most images of its camera are 640x480"));
}

TEST_F(BadInput, AnotherBoardSaysHowManyCornersWereSeen) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(9);
  for (const char* board : {"chessboard:7x6:25mm", "chessboard:9x7:25mm", "chessboard:6x4:25mm"}) {
    refuses(images(board), 3, {"9x6 inner corners"});
  }
}

// Two boards that are alike would both be found in the print of one, and each of its corners would count twice.
TEST_F(BadInput, TwoBoardsThatImagesDoNotTellApart) {
  const auto chessboard = [](const std::string& name, const std::string& size) {
    return "[[target]]\nname = \"" + name + "\"\nkind = \"chessboard\"\n" + size + "\nsquare_m = 0.025\n";
  };
  const std::string nine = "columns = 9\nrows = 6", eight = "columns = 8\nrows = 5";
  const std::string tags = "[[target]]\nkind = \"aprilgrid\"\ncolumns = 6\nrows = 6\ntag_m = 0.088\nspacing = 0.3\n";
  const auto refuses_boards = [&](const std::string& boards, const std::vector<std::string>& words) {
    write_text(place / "left1.jpg", "this is not an image");
    write_text(place / "dataset.toml",
               boards + "[[camera]]\nname = \"c\"\nmodel = \"pinhole\"\nimages = \"left1.jpg\"\n");
    refuses({(place / "dataset.toml").string()}, 2, words);
  };
  refuses_boards(chessboard("a", nine) + chessboard("b", eight), {"'a' from 'b'", "ChArUco"});
  refuses_boards(tags + tags + "first_tag = 35\n", {"'board' from 'board2'", "the same markers"});
  // OpenCV's dictionary of 50 codes is the beginning of the one of 100, and 36h11 the same in both kinds of boards.
  const auto charuco = [](const std::string& dictionary) {
    return "[[target]]\nkind = \"charuco\"\ncolumns = 8\nrows = 6\nsquare_m = 0.03\nmarker_m = 0.02\ndictionary = \"" +
           dictionary + "\"\n";
  };
  refuses_boards(charuco("DICT_4X4_50") + charuco("DICT_4X4_100"), {"'board' from 'board2'", "the same markers"});
  refuses_boards(tags + "border_bits = 1\n" + charuco("DICT_APRILTAG_36h11"), {"the same markers"});
  refuses_boards(chessboard("a", nine) + chessboard("a", nine), {"dataset.toml:7", "two [[target]] are called 'a'"});
}

// What is not there needs no value.
TEST_F(BadInput, RulesForNoParameterSayWhichThereAre) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(3);
  std::vector<std::string> arguments = images();
  arguments.insert(arguments.end(), {"--fix", "nothing.fx"});
  refuses(arguments, 2, {"no parameter matches 'nothing.fx'; there are: left.intrinsics, left.fx"});
}

TEST_F(BadInput, FewerThanThreeViews) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(2);
  refuses(images(), 3, {"camera left", "there are only 2 views of the board", "three"});
}

// A board that only turns in its own plane and moves: every focal length explains it, at another distance.
TEST_F(BadInput, BoardAlwaysParallelToTheImage) {
  std::mt19937 random(1);
  for (const double noise_px : {0.0, 0.1}) {
    std::normal_distribution<double> noise(0.0, 1.0);
    std::string csv = "camera,frame,point_id,u,v\n";
    for (int frame = 0; frame < 12; ++frame) {
      const double scale = 1500.0 + 90.0 * frame, turn = 0.2 * frame;  // [px/m], [rad]
      for (int id = 0; id < 35; ++id) {
        const double x = 0.04 * (id % 7 - 3), y = 0.04 * (id / 7 - 2);
        const double u = 320 + 12 * (frame % 5 - 2) + scale * (std::cos(turn) * x - std::sin(turn) * y);
        const double v = 240 + 10 * (frame % 3 - 1) + scale * (std::sin(turn) * x + std::cos(turn) * y);
        if (u < 0 || u > 639 || v < 0 || v > 479) continue;
        csv += fmt::format("a,{},{},{:.6f},{:.6f}\n", frame, id, u + noise_px * noise(random),
                           v + noise_px * noise(random));
      }
    }
    refuses_corners("parallel.csv", csv, 3, {"camera a", "parallel", "tilt"});
  }
}

// Times that differ by microseconds are different frames: what belongs together is not guessed.
TEST_F(BadInput, TwoCamerasWhoseImagesHaveNoNumberInCommon) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  const char* letters = "abcdef";
  for (int i = 0; i < 6; ++i) {
    for (const std::string side : {"left", "right"}) {
      const fs::path image = real_data(kImages) / fmt::format("{}{:02}.jpg", side, i + 1);
      fs::copy_file(image, place / fmt::format("{}_{}.jpg", side, letters[i]));
      fs::copy_file(image, place / fmt::format("{}_at_140370939593783{}0{}.jpg", side, i, side == "left" ? 31 : 74));
    }
  }
  const auto refuses_pair = [&](const std::string& names, const std::vector<std::string>& words) {
    refuses(
        {"--target", "chessboard:9x6:25mm", "--model", "brown_conrady", "--camera",
         "left=" + (place / ("left" + names)).string(), "--camera", "right=" + (place / ("right" + names)).string()},
        3, words);
  };
  refuses_pair("_?.jpg", {"left_a.jpg is frame left_a of camera left", "right_a.jpg is frame right_a of camera right"});
  refuses_pair("_at_*.jpg", {"is frame 140370939593783", "of camera right", "name the images of one moment alike"});
}

TEST_F(BadInput, TwoCamerasWithoutASharedFrame) {
  SyntheticOptions options;
  options.cameras.resize(2);
  options.frames = 16;
  SyntheticWorld world = synthetic_world(options);
  std::erase_if(world.problem.views, [](const TargetView& view) { return (view.frame < 8) != (view.camera == 0); });
  write_text(place / "apart.csv", csv_of(world.problem));
  refuses({"--observations", (place / "apart.csv").string(), "--target", "chessboard:9x7:40mm", "--image-size",
           "camera0=1280x960", "--image-size", "camera1=1280x960", "--model", "kannala_brandt"},
          3, {"camera0", "camera1", "see the same board"});
}

// What observations.json says itself and a flag says otherwise would be ignored without a word.
TEST_F(BadInput, FlagsThatObservationsMakeIdle) {
  const ObservationsFile file{synthetic_world({}).problem, {}};
  const std::string json = (place / "corners.json").string();
  write_text(json, text_from_observations(file));
  const std::vector<std::string> rest{"--observations", json, "--model", "kannala_brandt"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), rest.begin(), rest.end());
    return more;
  };
  refuses(with({"--target", "chessboard:9x7:50mm"}), 2, {"corners.json", "another board than chessboard:9x7:50mm"});
  refuses(with({"--image-size", "camera0=640x480"}), 2, {"--image-size", "leave it out"});
  refuses(with({"--camera", "camera0=*.jpg"}), 2, {"--camera", "corners.json", "leave out"});
  refuses(with({"--model", "nix=pinhole"}), 2, {"--model 'nix=pinhole'", "does not exist"});
  const nlohmann::json report = calibrate(place, with({"--target", "chessboard:9x7:40mm"}));  // says it once more
  EXPECT_TRUE(report.contains("cameras"));
}

TEST_F(BadInput, MalformedFilesAreNamedWithTheirLine) {
  refuses_corners("broken.csv", "camera,frame,point_id,u,v\na,1,0,10,20\na,1,1,ten,20\n", 2, {"broken.csv:3"});
  write_text(place / "broken.json", "{\"format\": \"raybundle observations\",\n \"version\": 1,\n \"targets\" [}\n");
  refuses({"--observations", (place / "broken.json").string(), "--model", "pinhole"}, 2, {"broken.json:3"});
  write_text(place / "broken.vnl", "# filename x y level\na-1.jpg 10 20 0\na-1.jpg ten 20 0\n");
  refuses({"--observations", (place / "broken.vnl").string(), "--target", "chessboard:7x5:40mm", "--camera",
           "a=a-*.jpg", "--image-size", "a=640x480", "--model", "pinhole"},
          2, {"broken.vnl:3"});
  write_text(place / "broken.toml", "[target]\nkind = \"chessboard\"\ncolumns = = 9\n");
  refuses({(place / "broken.toml").string()}, 2, {"broken.toml:3"});
}

TEST_F(BadInput, UnknownKeysAndModelsComeWithASuggestion) {
  const std::string board = "[target]\nkind = \"chessboard\"\ncolumns = 9\nrows = 6\nsquare_m = 0.025\n";
  write_text(place / "key.toml", board + "[[camera]]\nname = \"a\"\nimage = \"*.jpg\"\nmodel = \"pinhole\"\n");
  refuses({(place / "key.toml").string()}, 2, {"key.toml:"});
  write_text(place / "key.toml",
             board + "[[camera]]\nname = \"a\"\nimages = \"*.jpg\"\nmodell = \"x\"\nmodel = \"pinhole\"\n");
  refuses({(place / "key.toml").string()}, 2, {"key.toml:9", "modell", "id you mean", "model"});
  write_text(place / "board.toml", "[target]\nkind = \"chessboard\"\ncolumns = 9\nrows = 6\nsqare_m = 0.025\n");
  refuses({(place / "board.toml").string()}, 2, {"board.toml:", "square_m"});
  refuses({"--target", "chessboard:9x6:25mm", "--camera", "a=*.jpg", "--model", "kanala_brandt"}, 2,
          {"kanala_brandt", "id you mean", "kannala_brandt"});
}

TEST_F(BadInput, WhatIsMissingIsNamed) {
  refuses({"--target", "chessboard:9x6:25mm", "--camera", "a=*.jpg"}, 2, {"camera a", "--model"});
  refuses({"--camera", "a=*.jpg", "--model", "pinhole"}, 2, {"which board", "--target"});
  refuses({"--target", "chessboard:9x6:25mm", "--model", "pinhole"}, 2, {"which images", "--camera"});
  refuses({"--observations", "left01.jpg"}, 2, {"left01.jpg is an image, not a file of corners", "--camera"});
  refuses({"--target", "chessboard:9x6", "--camera", "a=*.jpg", "--model", "pinhole"}, 2, {"chessboard"});
  refuses({"--target", "chessbord:9x6:25mm", "--camera", "a=*.jpg", "--model", "pinhole"}, 2, {"chessboard"});
}

// A path below a regular file cannot be made by anyone, root or not; it is found out before the images are read.
TEST_F(BadInput, OutputFolderCannotBeMade) {
  RAYBUNDLE_NEEDS_DATA(kImages);
  copy_images(3);
  write_text(place / "file", "a file");
  for (const char* folder : {"file", "file/out"}) {
    std::vector<std::string> arguments = images();
    arguments.insert(arguments.begin(), "calibrate");
    arguments.insert(arguments.end(), {"-o", (place / folder).string()});
    const ProgramRun run = raybundle_program(arguments);
    EXPECT_EQ(run.exit_code, 5) << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr((place / folder).string()));
  }
  EXPECT_EQ(text_of(place / "file"), "a file");
}

TEST_F(BadInput, OutputFolderWithoutAName) {
  std::vector<std::string> arguments = images();
  arguments.insert(arguments.begin(), "calibrate");
  arguments.insert(arguments.end(), {"-o", ""});
  const ProgramRun run = raybundle_program(arguments);
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_THAT(run.err, HasSubstr("the output folder has no name; give one with -o"));
}

TEST_F(BadInput, DetectionWithoutABoardLeavesTheEarlierCorners) {
  cv::imwrite((place / "left1.png").string(), cv::Mat(480, 640, CV_8U, cv::Scalar(128)));
  write_text(place / "observations.json", kOld);
  const ProgramRun run =
      raybundle_program({"detect", "--target", "chessboard:9x6:25mm", "--camera",
                         "left=" + (place / "left*.png").string(), "-o", (place / "observations.json").string()});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("no board was found"));
  EXPECT_EQ(text_of(place / "observations.json"), kOld);
}

TEST_F(BadInput, ValidateRefusesCamerasThatAreNotInTheCalibration) {
  SyntheticOptions options;
  const SyntheticWorld world = synthetic_world(options);
  const fs::path good = fresh_folder() / "good";
  fs::create_directories(good);
  std::string csv = csv_of(world.problem);
  write_text(good / "corners.csv", csv);
  calibrate(good, {"--observations", (good / "corners.csv").string(), "--target", "chessboard:9x7:40mm", "--image-size",
                   "camera0=1280x960", "--model", "kannala_brandt"});
  for (std::size_t at = csv.find("camera0"); at != std::string::npos; at = csv.find("camera0")) {
    csv.replace(at, 7, "camera9");
  }
  write_text(good / "other.csv", csv);
  const std::string file = (good / "out" / "calibration.json").string();
  const ProgramRun run = raybundle_program({"validate", file, "--observations", (good / "other.csv").string(),
                                            "--target", "chessboard:9x7:40mm", "--image-size", "camera9=1280x960"});
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_THAT(run.err, HasSubstr("camera9"));
  EXPECT_THAT(run.err, HasSubstr("camera0"));
}

TEST_F(BadInput, StartFromImagesOfAnotherSize) {
  const SyntheticWorld world = synthetic_world({});
  const fs::path good = fresh_folder() / "good";
  fs::create_directories(good);
  const auto corners = [&](int width, int height) {
    CalibrationProblem problem = world.problem;
    problem.cameras[0].size = {width, height};
    const fs::path file = good / fmt::format("{}.json", width);
    write_text(file, text_from_observations({problem, {}}));
    return std::vector<std::string>{"--observations", file.string(), "--model", "kannala_brandt"};
  };
  calibrate(good, corners(1280, 960));
  std::vector<std::string> larger = corners(1920, 1440);
  larger.insert(larger.end(), {"--start", (good / "out" / "calibration.json").string()});
  refuses(larger, 2, {"camera0", "1920x1440", "1280x960", "calibration.json"});
}

}  // namespace
}  // namespace raybundle::testing
