// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <thread>

#include "program.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

constexpr std::array<const char*, 3> kResults{"calibration.json", "report.json", "report.html"};
constexpr const char* kOld = "{\"an\": \"earlier result\"}";

/// What a run may not have.
struct Limits {
  rlim_t file_bytes = RLIM_INFINITY;
  rlim_t memory_bytes = RLIM_INFINITY;
  std::string standard_output{};  ///< a device to write it to
};

std::string all_of(int descriptor) {
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t count = 0; (count = ::read(descriptor, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(descriptor);
  return text;
}

/// Runs the program under limits; its streams are pipes, so that the limits of files are not theirs.
ProgramRun limited(const std::vector<std::string>& arguments, const Limits& limits) {
  std::vector<std::string> words{RAYBUNDLE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const std::string cache = cache_of_this_build().string();
  std::array<int, 2> out{}, err{};
  if (::pipe(out.data()) != 0 || ::pipe(err.data()) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit file{limits.file_bytes, limits.file_bytes}, memory{limits.memory_bytes, limits.memory_bytes};
    const int device = limits.standard_output.empty() ? out[1] : ::open(limits.standard_output.c_str(), O_WRONLY);
    ::dup2(device, STDOUT_FILENO);
    ::dup2(err[1], STDERR_FILENO);
    for (const int each : {out[0], out[1], err[0], err[1]}) ::close(each);
    ::setenv("XDG_CACHE_HOME", cache.c_str(), 1);
    ::setrlimit(RLIMIT_FSIZE, &file);
    ::setrlimit(RLIMIT_AS, &memory);
    ::execv(pointers.front(), pointers.data());
    ::_exit(127);
  }
  ::close(out[1]);
  ::close(err[1]);
  ProgramRun run;
  std::thread reader([&] { run.out = all_of(out[0]); });
  run.err = all_of(err[0]);
  reader.join();
  int status = 0;
  ::waitpid(child, &status, 0);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return run;
}

/// A calibration from corners in a table, and the results of an earlier one.
class Fault : public ::testing::Test {
 protected:
  void SetUp() override {
    SyntheticOptions options;
    options.frames = 10;
    write_text(place / "corners.csv", csv_of(synthetic_world(options).problem));
    fs::create_directories(place / "out");
    for (const char* name : kResults) write_text(place / "out" / name, kOld);
  }

  std::vector<std::string> calibration(const std::string& output) const {
    return {"calibrate",
            "--observations",
            (place / "corners.csv").string(),
            "--target",
            "chessboard:9x7:40mm",
            "--image-size",
            "camera0=1280x960",
            "--model",
            "kannala_brandt",
            "-o",
            (place / output).string()};
  }

  /// One clear sentence, and every file as it was.
  void expect_nothing_lost(const ProgramRun& run, const std::string& word) const {
    EXPECT_EQ(run.exit_code, 5) << run.err;
    EXPECT_TRUE(run.err.starts_with("raybundle: error: ")) << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr(word));
    expect_old();
  }

  void expect_old() const {
    for (const char* name : kResults) EXPECT_EQ(text_of(place / "out" / name), kOld) << name;
    EXPECT_EQ(std::distance(fs::directory_iterator(place / "out"), {}), 3) << "a file was left behind";
  }

  fs::path place = fresh_folder();
};

// The disk is full after so many bytes of a file: in the first file, the second, the third, or none of them.
TEST_F(Fault, AFullDiskLeavesTheEarlierResults) {
  ASSERT_EQ(limited(calibration("whole"), {}).exit_code, 0);
  rlim_t largest = 0;
  for (const char* name : kResults) {
    const rlim_t size = fs::file_size(place / "whole" / name);
    largest = std::max(largest, size);
    const ProgramRun run = limited(calibration("out"), {.file_bytes = size / 2});
    expect_nothing_lost(run, "has space left");
  }
  expect_nothing_lost(limited(calibration("out"), {.file_bytes = 0}), "has space left");
  // Some more than the largest: times in the report have not always the same number of digits.
  EXPECT_EQ(limited(calibration("out"), {.file_bytes = largest + 4096}).exit_code, 0);
  EXPECT_NE(text_of(place / "out" / "report.json"), kOld);
}

TEST_F(Fault, AFailedRunLeavesNoFolder) {
  expect_nothing_lost(limited(calibration("new/folder"), {.file_bytes = 100}), "has space left");
  EXPECT_FALSE(fs::exists(place / "new"));
  write_text(place / "corners.csv", "camera,frame,point_id,u,v\ncamera0,1,0,10,20\n");
  EXPECT_EQ(limited(calibration("new/folder"), {}).exit_code, 3);
  EXPECT_FALSE(fs::exists(place / "new"));
}

// What a full disk does to `raybundle ... > file`.
TEST_F(Fault, StandardOutputThatCannotBeWritten) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "there is no /dev/full to write to";
  std::vector<std::vector<std::string>> commands{{"--help"}, {"--version"}, {"calibrate", "--help"}};
  for (const char* flag : {"--json", "--no-cache"}) {
    commands.push_back(calibration("new"));
    commands.back().push_back(flag);
  }
  for (const std::vector<std::string>& arguments : commands) {
    const ProgramRun run = limited(arguments, {.standard_output = "/dev/full"});
    EXPECT_EQ(run.exit_code, 5) << run.err;
    EXPECT_THAT(run.err, HasSubstr("standard output cannot be written"));
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  }
}

TEST_F(Fault, CornersThatCannotBeWritten) {
  if (!fs::is_character_file("/dev/full")) GTEST_SKIP() << "there is no /dev/full to write to";
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::vector<std::string> images{"detect", "--target", "chessboard:9x6:25mm", "--camera",
                                        "left=" + (real_data("opencv_stereo_chess") / "left01.jpg").string()};
  std::vector<std::string> to_device = images;
  to_device.insert(to_device.end(), {"-o", "/dev/full"});
  expect_nothing_lost(limited(to_device, {}), "/dev/full");
  std::vector<std::string> to_file = images;
  to_file.insert(to_file.end(), {"-o", (place / "out" / "report.json").string()});
  expect_nothing_lost(limited(to_file, {.file_bytes = 10}), "has space left");
}

// Memory that runs out anywhere between the start and the last byte. How much the program needs is searched for, so
// that the limits lie where its own work is; below them not even its libraries fit.
TEST_F(Fault, TooLittleMemoryLeavesTheEarlierResults) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers need more address space than any limit allows";
#endif
  constexpr rlim_t kStep = 1 << 20;
  rlim_t too_little = 0;
  for (rlim_t least = 0, most = rlim_t{1} << 32; most - least > kStep;) {
    const rlim_t middle = (least + most) / 2;
    const bool runs = limited({"--version"}, {.memory_bytes = middle}).exit_code == 0;
    (runs ? most : least) = middle;
    too_little = most;
  }
  int refused = 0;
  for (rlim_t limit = too_little; limit < too_little + (rlim_t{1} << 30); limit += 4 * kStep) {
    const ProgramRun run = limited(calibration("out"), {.memory_bytes = limit});
    if (run.exit_code == 0) break;
    ++refused;
    EXPECT_EQ(run.exit_code, 5) << limit << ": " << run.err;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    EXPECT_THAT(run.err, AnyOf(HasSubstr("memory"), HasSubstr("Resource temporarily unavailable")));
    expect_old();
  }
  EXPECT_GT(refused, 0);
  EXPECT_NE(text_of(place / "out" / "report.json"), kOld);
}

}  // namespace
}  // namespace raybundle::testing
