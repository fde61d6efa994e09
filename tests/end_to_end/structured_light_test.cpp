// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <thread>

#include "browser.hpp"
#include "eye_safety_limits.hpp"
#include "mesh_files.hpp"
#include "program.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;

using apps::kSafetyEditions;
using apps::safety_limit;

// The figures of Boverie, Devy, Lerasle 2006, section 2.2: 0.78 mW, and "a factor 2" more for shorter pulses.
TEST(EyeSafety, GivesThePublishedFigures) {
  EXPECT_NEAR(1e3 * safety_limit({.wavelength_nm = 850, .pulse_s = 1e-3, .rate_Hz = 100}, kSafetyEditions[0]).least_W(),
              0.785, 0.0005);
  EXPECT_NEAR(1e3 * safety_limit({.wavelength_nm = 850, .pulse_s = 1e-4, .rate_Hz = 100}, kSafetyEditions[0]).least_W(),
              1.397, 0.0005);
}

TEST(EyeSafety, NeverAllowsMoreThanItsAverageAndASinglePulse) {
  for (const auto& edition : kSafetyEditions) {
    for (const double pulse_s : {1e-8, 1e-6, 1e-4, 1e-2}) {
      const auto limit = safety_limit({.wavelength_nm = 830, .pulse_s = pulse_s, .rate_Hz = 50}, edition);
      EXPECT_LE(limit.least_W(), limit.single_pulse_W);
      EXPECT_LE(limit.least_W(), limit.average_W);
      EXPECT_GT(limit.least_W(), 0.0);
    }
  }
  EXPECT_THROW(safety_limit({.wavelength_nm = 650}, kSafetyEditions[0]), Error);
  EXPECT_THROW(safety_limit({.pulse_s = 0.1, .rate_Hz = 20}, kSafetyEditions[0]), Error);
}

// Worked by hand from the tables of the 2014 edition.
TEST(EyeSafety, CountsSizeAndNumberByTheLaterEdition) {
  const apps::SafetyEdition& later = kSafetyEditions[2];
  const auto limit = [&](double pulse_s, double rate_Hz, double source_mrad) {
    return safety_limit({.wavelength_nm = 850, .pulse_s = pulse_s, .rate_Hz = rate_Hz, .source_mrad = source_mrad},
                        later);
  };
  EXPECT_NEAR(limit(1e-3, 100, 50).c6, 200 * std::sqrt(1e-3) / 1.5, 1e-12);  // 6.3 mrad count of a pulse of 1 ms
  EXPECT_NEAR(limit(1e-4, 100, 50).c6, 5 / 1.5, 1e-12);
  EXPECT_EQ(limit(1e-3, 100, 1.5).c5, 1.0);                                 // small
  EXPECT_EQ(limit(1e-3, 100, 6).c5, 0.4);                                   // of a size that counts
  EXPECT_EQ(limit(1e-3, 100, 50).c5, 0.2);                                  // larger
  EXPECT_NEAR(limit(1e-6, 100, 1.5).c5, 5 * std::pow(1000, -0.25), 1e-12);  // short: 1000 pulses in 10 s
  EXPECT_EQ(limit(1e-6, 50, 1.5).c5, 1.0);                                  // 500
  EXPECT_NEAR(limit(1e-3, 100, 100).exposure_s, 100, 1e-9);                 // T2
  EXPECT_NEAR(limit(1e-3, 100, 1.5).exposure_s, 10, 1e-12);
  // 3.9e-4 C4 W of mean power for a point, at a duty of a tenth.
  EXPECT_NEAR(limit(1e-3, 100, 1.5).average_W, 10 * 3.9e-4 * std::pow(10, 0.3), 1e-12);
  EXPECT_THROW(limit(1e-7, 1e6, 1.5), Error);  // groups of pulses
}

TEST(EyeSafety, CountsBeamsThatEnterAnApertureTogether) {
  const auto beam = [](double angle) { return Line3{Eigen::Vector3d::Zero(), {std::sin(angle), 0, std::cos(angle)}}; };
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.15), beam(0.3)}, 0.1), 1);
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.06), beam(0.3)}, 0.1), 2);  // 6 mm apart at 100 mm
  EXPECT_EQ(apps::beams_in_aperture({beam(0.0), beam(0.03), beam(0.06), beam(0.09)}, 0.1), 3);
}

TEST(EyeSafety, JudgesAPowerByItsExitCode) {
  const std::vector<std::string> drive{"eye-safety", "--edition", "1993", "--wavelength", "850", "--power"};
  const auto run = [&](const char* power) {
    std::vector<std::string> arguments = drive;
    arguments.emplace_back(power);
    return raybundle_program(arguments);
  };
  EXPECT_EQ(run("0.7").exit_code, 0);
  const ProgramRun above = run("0.9");
  EXPECT_EQ(above.exit_code, 1);
  EXPECT_NE(above.out.find("not a compliance verdict"), std::string::npos);
  EXPECT_EQ(raybundle_program({"eye-safety"}).exit_code, 2);  // the edition is never assumed
}

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
                 second = live / fs::path(on_[1]).filename(), points = folder_ / "points", err = folder_ / "err";
  fs::create_directory(live);
  fs::copy(on_[0], first);
  write_text(live / "broken.png", "no image");
  const auto taken = [&](const fs::path& image) { return fs::exists(points / (image.stem().string() + ".json")); };
  const auto wait_for = [](auto&& done) {  // at most half a minute, on a machine with much else to do
    for (int tick = 0; tick < 300 && !done(); ++tick) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return done();
  };
  const RunningProgram program(
      {"reconstruct", "structured-light", truth_, "--watch", live.string(), "-o", points.string()}, err);
  EXPECT_TRUE(wait_for([&] { return taken(first); }));
  write_text(second, text_of(on_[1]).substr(0, 20000));
  std::this_thread::sleep_for(std::chrono::milliseconds(800));
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

}  // namespace
}  // namespace raybundle::testing
