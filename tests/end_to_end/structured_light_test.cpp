// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "browser.hpp"
#include "mesh_files.hpp"
#include "program.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

TEST(MeshFiles, HoldWhatTheySay) {
  const apps::PointMesh mesh{
      .points = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, .triangles = {{0, 2, 1}}, .names = {"row"}, .numbers = {{4, 5, 6}}};
  const std::string ply = apps::ply_from(mesh);
  EXPECT_NE(ply.find("element vertex 3\n"), std::string::npos);
  EXPECT_NE(ply.find("\n1 0 1 5\n"), std::string::npos);
  EXPECT_TRUE(ply.ends_with("3 0 2 1\n"));
  const std::string glb = apps::glb_from(mesh);
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  std::uint32_t length = 0, json_length = 0;
  std::memcpy(&length, glb.data() + 8, 4);
  std::memcpy(&json_length, glb.data() + 12, 4);
  EXPECT_EQ(length, glb.size());
  const auto gltf = nlohmann::json::parse(glb.substr(20, json_length));
  EXPECT_EQ(gltf["accessors"][0]["count"], 3);
  EXPECT_EQ(gltf["accessors"][1]["count"], 3);
  EXPECT_EQ(gltf["buffers"][0]["byteLength"], 3 * 12 + 3 * 4);
  EXPECT_EQ(gltf["scenes"][0]["nodes"][0], 0);
  EXPECT_EQ(gltf["meshes"][0]["primitives"][0]["mode"], 4);
  EXPECT_EQ(nlohmann::json::parse(apps::glb_from({}).substr(20))["asset"]["version"], "2.0");
}

/// A simulated sensor and images of a board before it.
class StructuredLightProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder();
    // Of this seed both boards stand in the beams.
    const std::string rig = RAYBUNDLE_SOURCE_DIR "/datasets/rigs/rig_26mm_laser.toml";
    const ProgramRun run =
        raybundle_program({"simulate", rig, "--frames", "2", "--seed", "5", "-o", (folder_ / "sim").string()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    for (const auto& entry : fs::directory_iterator(folder_ / "sim/images/camera")) {
      const std::string name = entry.path().filename().string();
      if (name.find("_on") != std::string::npos) on_.push_back(entry.path().string());
      if (name.find("_off") != std::string::npos) off_.push_back(entry.path().string());
    }
    std::ranges::sort(on_);
    std::ranges::sort(off_);
    ASSERT_EQ(on_.size(), 2u);
    truth_ = (folder_ / "sim/truth/calibration.json").string();
  }

  ProgramRun reconstruct(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"reconstruct", "structured-light"});
    arguments.insert(arguments.end(), {"-o", (folder_ / "points").string()});
    return raybundle_program(arguments);
  }

  fs::path folder_;
  std::vector<std::string> on_, off_;
  std::string truth_;
};

TEST_F(StructuredLightProgram, TurnsImagesIntoPointsByCalibrationAndByTable) {
  const std::string table = (folder_ / "sensor.rbsl").string();
  const ProgramRun exported =
      raybundle_program({"export", truth_, "--runtime", "structured-light", "-o", table, "--json"});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_LT(nlohmann::json::parse(exported.out)["ray_error_rad"], 1e-5);
  EXPECT_EQ(
      raybundle_program({"export", truth_, "--runtime", "structured-light", "-o", table, "--width", "99"}).exit_code,
      2);  // which is of --rectification
  const ProgramRun ranged = reconstruct({table, on_[0], "--off", off_[0], "--nearest", "0.3"});
  EXPECT_EQ(ranged.exit_code, 2);
  EXPECT_NE(ranged.err.find("leave out --nearest"), std::string::npos) << ranged.err;
  const std::string name = fs::path(on_[0]).stem().string();
  const ProgramRun run = reconstruct({table, on_[0], "--off", off_[0]});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json points = json_of(folder_ / "points" / (name + ".json"));
  EXPECT_GT(points["points"].size(), 5u);
  for (const nlohmann::json& point : points["points"]) {
    EXPECT_GE(point["x_in_camera_m"][2], 0.15);
    EXPECT_LE(point["x_in_camera_m"][2], 1.5);
  }
  for (const char* ending : {".ply", ".glb", ".html"}) {
    EXPECT_TRUE(fs::exists(folder_ / "points" / (name + ending))) << ending;
  }
  const ProgramRun again = reconstruct({truth_, on_[0], "--off", off_[0]});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(json_of(folder_ / "points" / (name + ".json"))["points"], points["points"]);
}

TEST_F(StructuredLightProgram, ExportCountsForeseenBeamsApart) {
  nlohmann::json calibration = json_of(truth_), &laser = calibration["laser"];
  laser["beams"].erase(60);
  laser["grating"] = {{"rig_from_projector", {{"rotation_xyzw", {0, 0, 0, 1}}, {"translation_m", {0.06, 0, 0}}}},
                      {"column_pitch", 0.14},
                      {"row_pitch", 0.11},
                      {"skew_rad", 0},
                      {"k1", 0},
                      {"k2", 0},
                      {"shift_m", 0},
                      {"wavelength_scale", 1}};
  const std::string path = (folder_ / "with_grating.json").string();
  write_text(path, calibration.dump());
  const ProgramRun run = raybundle_program(
      {"export", path, "--runtime", "structured-light", "-o", (folder_ / "sensor.rbsl").string(), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json exported = nlohmann::json::parse(run.out);
  EXPECT_EQ(exported["beams"], laser["beams"].size());
  EXPECT_EQ(exported["foreseen_beams"], 121 - laser["beams"].size());
}

// An alarm stays, so that later images may well agree with the calibration: their figures are none of the alarm.
TEST_F(StructuredLightProgram, SaysOnceThatTheProjectorHasTurned) {
  constexpr const char* kTurned = "the projector seems to have turned";
  const Eigen::Vector3d projector(0.06, 0.003, -0.004);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2e-3, Eigen::Vector3d::UnitX()).toRotationMatrix();
  nlohmann::json calibration = json_of(truth_);
  for (nlohmann::json& beam : calibration["laser"]["beams"]) {
    const auto vector = [&](const char* key) { return Eigen::Vector3d(beam[key].get<std::array<double, 3>>().data()); };
    const Eigen::Vector3d point = projector + turn * (vector("point_m") - projector), u = turn * vector("direction");
    beam["point_m"] = {point.x(), point.y(), point.z()};
    beam["direction"] = {u.x(), u.y(), u.z()};
    for (std::size_t i = 0; i < 4; ++i) beam["covariance"][i][i] = 9e-8;  // 0.3 mm and 0.3 mrad: dots keep their labels
  }
  const std::string turned = (folder_ / "turned.json").string();
  write_text(turned, calibration.dump());
  std::vector<std::string> arguments{turned};
  for (std::size_t i = 0; i < 12; ++i) {  // the alarm comes amid them
    arguments.push_back((folder_ / ("image_" + std::to_string(i) + ".png")).string());
    fs::copy(on_[i % 2], arguments.back());
  }
  const ProgramRun run = reconstruct(arguments);
  EXPECT_EQ(run.exit_code, 1);
  const std::size_t first = run.err.find(kTurned);
  ASSERT_NE(first, std::string::npos) << run.err;
  EXPECT_EQ(run.err.find(kTurned, first + 1), std::string::npos) << run.err;
}

TEST_F(StructuredLightProgram, TakesImagesAsTheyComeIntoAFolder) {
  fs::create_directory(folder_ / "live");
  for (const std::string& image : on_) fs::copy(image, folder_ / "live");
  const ProgramRun run = reconstruct({truth_, "--watch", (folder_ / "live").string(), "--frames", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const std::string& image : on_) {
    EXPECT_TRUE(fs::exists(folder_ / "points" / (fs::path(image).stem().string() + ".json"))) << image;
  }
}

// Frames of a video, with one without the laser beside it or not, say what the images say that they were made of.
TEST_F(StructuredLightProgram, TakesTheFramesOfVideos) {
  const auto video_of = [&](const std::vector<std::string>& images, const char* name) {
    const std::string path = (folder_ / name).string();
    const cv::Mat first = cv::imread(images[0]);
    cv::VideoWriter video(path, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 10, first.size());  // loses nothing
    for (const std::string& image : images) video.write(cv::imread(image));
    return path;
  };
  const std::string on = video_of(on_, "lit.avi"), off = video_of(off_, "dark.avi");
  const auto points_of = [&](std::vector<std::string> arguments, const std::string& name) {
    arguments.insert(arguments.begin(), truth_);
    const ProgramRun run = reconstruct(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json_of(folder_ / "points" / (name + ".json"))["points"];
  };
  const nlohmann::json second = points_of({on, "--off", off}, "lit_000001");
  EXPECT_TRUE(fs::exists(folder_ / "points/lit_000000.glb"));
  EXPECT_EQ(second, points_of({on_[0], on_[1], "--off", off_[0], off_[1]}, fs::path(on_[1]).stem().string()));
  for (const char* ending : {".json", ".ply", ".glb", ".html"}) {  // they would be taken for more of the sequence
    EXPECT_FALSE(fs::exists(folder_ / ("points/lit_000000" + std::string(ending)))) << "is of the former run";
  }
  EXPECT_GT(second.size(), 5u);
  fs::remove_all(folder_ / "points");
  EXPECT_GT(points_of({"--watch", on, "--frames", "1"}, "lit_000000").size(), 5u);
  EXPECT_FALSE(fs::exists(folder_ / "points/lit_000001.json"));

  EXPECT_EQ(reconstruct({truth_, on, "--off", off_[0]}).exit_code, 2);
  EXPECT_EQ(reconstruct({truth_, on, "--off", video_of({off_[0]}, "short.avi")}).exit_code, 2);
  write_text(folder_ / "no.mp4", "no video");
  EXPECT_EQ(reconstruct({truth_, (folder_ / "no.mp4").string()}).exit_code, 5);
}

// The program in the background, to be interrupted.
class RunningProgram {
 public:
  RunningProgram(std::vector<std::string> arguments, const fs::path& err) {
    arguments.insert(arguments.begin(), RAYBUNDLE_PROGRAM);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    process_ = fork();
    if (process_ != 0) return;
    if (std::freopen(err.c_str(), "w", stderr) == nullptr || std::freopen("/dev/null", "w", stdout) == nullptr)
      _exit(99);
    execv(pointers[0], pointers.data());
    _exit(99);
  }

  /// Its exit code after a signal; -1 when that ended it.
  int end_by(int signal) const {
    int status = 0;
    kill(process_, signal);
    waitpid(process_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

 private:
  pid_t process_ = -1;
};

// A file is taken when it is whole, others are named and passed over, and a signal ends it well.
TEST_F(StructuredLightProgram, WatchesAFolderUntilItIsInterrupted) {
  const fs::path live = folder_ / "live", first = live / fs::path(on_[0]).filename(),
                 second = live / fs::path(on_[1]).filename(), later = live / "later.png", points = folder_ / "points",
                 err = folder_ / "err";
  fs::create_directory(live);
  fs::copy(on_[0], first);
  write_text(live / "broken.png", "no image");
  const auto taken = [&](const fs::path& image) { return fs::exists(points / (image.stem().string() + ".json")); };
  const auto wait_for = [](auto&& done) {  // at most half a minute, on a machine with much else to do
    for (int tick = 0; tick < 1500 && !done(); ++tick) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return done();
  };
  const RunningProgram program(
      {"reconstruct", "structured-light", truth_, "--watch", live.string(), "-o", points.string()}, err);
  EXPECT_TRUE(wait_for([&] { return taken(first); }));
  write_text(second, text_of(on_[1]).substr(0, 20000));
  fs::copy(on_[0], later);  // files are looked at in the order of their names: when it is taken, the half one has been
  EXPECT_TRUE(wait_for([&] { return taken(later); }));
  EXPECT_FALSE(taken(second));
  fs::copy_file(on_[1], second, fs::copy_options::overwrite_existing);
  EXPECT_TRUE(wait_for([&] { return taken(second); }));
  EXPECT_TRUE(wait_for([&] { return text_of(err).find("broken.png") != std::string::npos; }));
  EXPECT_EQ(program.end_by(SIGTERM), 0);
}

TEST_F(StructuredLightProgram, ShowsItsPageWithoutErrors) {
  if (browser_name().empty()) GTEST_SKIP() << "there is no Chromium: install it to look at pages";
  const ProgramRun run = reconstruct({truth_, on_[0], "--off", off_[0]});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string name = fs::path(on_[0]).stem().string();
  const nlohmann::json frame = json_of(folder_ / "points" / (name + ".json"));
  Browser browser(folder_ / "profile");
  browser.open(folder_ / "points" / (name + ".html"));
  EXPECT_TRUE(browser.errors.empty()) << browser.errors.front();
  for (const std::string& request : browser.requests) {  // the page alone and what it holds: nothing is fetched
    EXPECT_TRUE(request.starts_with("file:") || request.starts_with("data:")) << request;
  }
  EXPECT_EQ(browser.evaluate("document.getElementById('state').textContent"), frame["state"]);
  const auto count = [&](const char* selector) {
    return browser.evaluate(std::string("document.querySelectorAll('") + selector + "').length").get<std::size_t>();
  };
  EXPECT_EQ(count("#image circle"), frame["points"].size());
  EXPECT_EQ(count("#image path"), frame["dots"].size() - frame["points"].size());
  EXPECT_EQ(count("#side circle"), frame["points"].size());
}

TEST_F(StructuredLightProgram, SaysWhatIsWrongWithItsInput) {
  const auto says = [&](std::vector<std::string> arguments, int exit_code, const char* words) {
    const ProgramRun run = reconstruct(std::move(arguments));
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  };
  says({truth_}, 2, "give images");
  says({truth_, on_[0], on_[1], "--off", off_[1]}, 2, fs::path(on_[0]).filename().c_str());  // the lonely one
  says({truth_, on_[0], "--off", off_[0], off_[1]}, 2, "no image with the laser on");
  says({truth_, "--watch", (folder_ / "nowhere").string()}, 5, "no folder to watch");
  const std::string cut = (folder_ / "cut.png").string();
  write_text(cut, text_of(on_[0]).substr(0, 20000));
  says({truth_, cut}, 5, "truncated");
  const std::string small = (folder_ / "small.png").string();
  cv::imwrite(small, cv::Mat(240, 320, CV_8U, cv::Scalar(9)));
  says({truth_, small}, 2, "320x240");
  says({truth_, "nothing*.png"}, 5, "nothing*.png");
  write_text(folder_ / "cut.rbsl", "RBSLTABL and no more");
  says({(folder_ / "cut.rbsl").string(), on_[0]}, 2, "structured-light table");
  const std::string plain = (folder_ / "plain.json").string();
  nlohmann::json calibration = json_of(truth_);
  calibration.erase("laser");
  write_text(plain, calibration.dump());
  says({plain, on_[0]}, 2, "no laser beams");
  EXPECT_FALSE(fs::exists(folder_ / "points"));
}

// The same light in 8 bits, 12 of 16 bits and in colour gives the same points.
TEST_F(StructuredLightProgram, ReadsDeepAndColouredImages) {
  const auto points_of = [&](const std::string& on, const std::string& off) {
    const ProgramRun run = reconstruct({truth_, on, "--off", off});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json_of(folder_ / "points" / (fs::path(on).stem().string() + ".json"))["points"];
  };
  const nlohmann::json plain = points_of(on_[0], off_[0]);
  cv::Mat on = cv::imread(on_[0], cv::IMREAD_GRAYSCALE), off = cv::imread(off_[0], cv::IMREAD_GRAYSCALE), coloured;
  cv::cvtColor(on, coloured, cv::COLOR_GRAY2BGR);
  on.convertTo(on, CV_16U, 16.0);
  off.convertTo(off, CV_16U, 16.0);
  const auto file = [&](const char* name) { return (folder_ / name).string(); };
  cv::imwrite(file("deep_1.png"), on);
  cv::imwrite(file("dark_1.png"), off);
  cv::imwrite(file("colour.png"), coloured);
  EXPECT_EQ(points_of(file("deep_1.png"), file("dark_1.png")).size(), plain.size());
  EXPECT_EQ(points_of(file("colour.png"), off_[0]), plain);
}

// The second image of a sequence would fit into 10 bits, the first one needs 12: both are scaled by these.
TEST_F(StructuredLightProgram, DarkerImagesOfASequenceStayDarker) {
  const auto file = [&](const char* name) { return (folder_ / name).string(); };
  for (const auto& [image, bright, dim] : {std::tuple(on_[0], file("on_1.png"), file("on_2.png")),
                                           std::tuple(off_[0], file("off_1.png"), file("off_2.png"))}) {
    cv::Mat deep;
    const cv::Mat grey = cv::imread(image, cv::IMREAD_GRAYSCALE);
    grey.convertTo(deep, CV_16U, 16.0);
    cv::imwrite(bright, deep);
    grey.convertTo(deep, CV_16U, 3.9);
    cv::imwrite(dim, deep);
  }
  const auto brightest_of_second = [&](const std::vector<std::string>& arguments) {
    const ProgramRun run = reconstruct(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json frame = json_of(folder_ / "points/on_2.json");
    double brightest = 0.0;
    for (const nlohmann::json& dot : frame["dots"]) {
      brightest = std::max<double>(brightest, dot["brightness"]);
    }
    return brightest;
  };
  const double alone = brightest_of_second({truth_, file("on_2.png"), "--off", file("off_2.png")});
  const double second =
      brightest_of_second({truth_, file("on_1.png"), file("on_2.png"), "--off", file("off_1.png"), file("off_2.png")});
  EXPECT_NEAR(second / alone, 0.25, 0.03);  // whole grey values, of a dot of which some hundreds are summed
}

}  // namespace
}  // namespace raybundle::testing
