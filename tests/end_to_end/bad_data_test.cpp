// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>

#include "program.hpp"
#include "raybundle/io/observations_file.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// Corners that no camera can have measured: each kind is named in a sentence, none is averaged in.
class BadData : public ::testing::Test {
 protected:
  static SyntheticWorld world(int frames = 14) {
    SyntheticOptions options;
    options.frames = frames;
    options.noise_px = 0.1;
    return synthetic_world(options);
  }

  std::vector<std::string> arguments(const std::string& file, const std::string& board = "chessboard:9x7:40mm") const {
    return {"calibrate",
            "--observations",
            (place / file).string(),
            "--target",
            board,
            "--image-size",
            "camera0=1280x960",
            "--model",
            "kannala_brandt",
            "-o",
            (place / "out").string()};
  }

  void refuses(const ProgramRun& run, const std::vector<std::string>& words) const {
    EXPECT_EQ(run.exit_code, 2) << run.err << run.out;
    EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
    for (const std::string& word : words) EXPECT_THAT(run.err, HasSubstr(word));
    EXPECT_FALSE(fs::exists(place / "out"));
  }

  /// Line `line` of a table of corners, spoilt.
  void refuses_line(const std::function<std::string(const std::string&)>& spoil, const std::string& word) const {
    std::istringstream lines(csv_of(world().problem));
    std::string text, line;
    constexpr int kLine = 100;
    for (int number = 1; std::getline(lines, line); ++number) text += (number == kLine ? spoil(line) : line) + "\n";
    write_text(place / "spoilt.csv", text);
    refuses(raybundle_program(arguments("spoilt.csv")), {word, "spoilt.csv"});
  }

  /// The same in observations.json.
  void refuses_problem(const std::function<void(CalibrationProblem&)>& spoil, const std::vector<std::string>& words) {
    ObservationsFile file{world().problem, {}};
    spoil(file.problem);
    write_text(place / "spoilt.json", text_from_observations(file));
    refuses(raybundle_program({"calibrate", "--observations", (place / "spoilt.json").string(), "--model",
                               "kannala_brandt", "-o", (place / "out").string()}),
            words);
  }

  /// Calibrates what is to be told and yet used; the standard output.
  std::string told(const CalibrationProblem& problem, const std::string& board = "chessboard:9x7:40mm") const {
    write_text(place / "corners.csv", csv_of(problem));
    const ProgramRun run = raybundle_program(arguments("corners.csv", board));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  }

  fs::path place = fresh_folder();
};

std::string with_field(const std::string& line, int field, const std::string& value) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string each; std::getline(stream, each, ',');) fields.push_back(each);
  fields[field] = value;
  std::string text;
  for (const std::string& each : fields) text += (text.empty() ? "" : ",") + each;
  return text;
}

TEST_F(BadData, NumbersThatAreNone) {
  for (const char* value : {"nan", "inf", "-inf", "1e999", "", "12px"}) {
    refuses_line([&](const std::string& line) { return with_field(line, 3, value); }, ":100: u is '");
  }
  refuses_line([](const std::string& line) { return line + ",nan"; }, ":100: sigma is 'nan'");
  refuses_line([](const std::string& line) { return line + ",0"; }, ":100: sigma is 0");
  refuses_line([](const std::string& line) { return line + ",1e-300"; }, "sigma that no measurement has");
  refuses_line([](const std::string& line) { return with_field(line, 2, "1000"); }, ":100: point 1000 is not on the");
  refuses_line([](const std::string& line) { return with_field(line, 4, "1e9"); }, "lies far outside");
}

TEST_F(BadData, NumbersThatAreNoneInJson) {
  const std::string whole = text_from_observations({world().problem, {}});
  const std::size_t points = whole.find("\"points\":", whole.find("\"views\":"));
  const std::size_t begin = whole.find(',', whole.find('[', points + 10)) + 1, end = whole.find(',', begin);
  for (const char* value : {"NaN", "1e999", "null", "\"12\"", "-Infinity"}) {
    write_text(place / "spoilt.json", whole.substr(0, begin) + value + whole.substr(end));
    refuses(raybundle_program({"calibrate", "--observations", (place / "spoilt.json").string(), "--model",
                               "kannala_brandt", "-o", (place / "out").string()}),
            {"spoilt.json:"});
  }
}

TEST_F(BadData, RepeatedIdsPixelsAndViews) {
  refuses_line([](const std::string& line) { return line + "\n" + line; }, ":101: the camera observes this point");
  refuses_problem(
      [](CalibrationProblem& problem) { problem.views[2].observations.push_back(problem.views[2].observations[0]); },
      {"point", "again"});
  refuses_problem(
      [](CalibrationProblem& problem) {
        problem.views[2].observations[4].pixel = problem.views[2].observations[9].pixel;
      },
      {"camera camera0, frame", "have the same pixel"});
  refuses_problem([](CalibrationProblem& problem) { problem.views.push_back(problem.views[3]); },
                  {"camera camera0, frame", "given twice"});
  refuses_problem(
      [](CalibrationProblem& problem) {
        problem.targets[0].points[5].x_in_target = problem.targets[0].points[8].x_in_target;
      },
      {"points 5 and 8", "same place"});
}

// The same image under two names would count twice, and a frozen camera many times.
TEST_F(BadData, RepeatedImagesAreNamedAndLeftOut) {
  CalibrationProblem problem = world().problem;
  const std::string plain = told(problem);
  const std::string once = without_provenance(place / "out" / "calibration.json");
  for (const char* name : {"900", "901"}) {
    TargetView copy = problem.views[4];
    copy.frame = static_cast<int>(problem.frames.size());
    problem.frames.push_back(name);
    problem.views.push_back(copy);
  }
  EXPECT_THAT(told(problem),
              HasSubstr("frame 901: shows exactly what frame " + problem.frames[problem.views[4].frame]));
  EXPECT_EQ(without_provenance(place / "out" / "calibration.json"), once);
}

TEST_F(BadData, ColumnsInTheWrongOrder) {
  CalibrationProblem problem = world().problem;
  for (TargetView& view : problem.views) {
    for (Observation& corner : view.observations) std::swap(corner.pixel.x(), corner.pixel.y());
  }
  write_text(place / "swapped.csv", csv_of(problem));
  refuses(raybundle_program(arguments("swapped.csv")), {"camera camera0", "u and v were swapped"});
}

TEST_F(BadData, ABoardInTheWrongUnitIsNamed) {
  const CalibrationProblem problem = world().problem;
  EXPECT_THAT(told(problem), Not(HasSubstr("unit")));
  EXPECT_THAT(told(problem, "chessboard:9x7:40m"), HasSubstr("lie 40 m apart: is the unit right"));
  EXPECT_THAT(told(problem, "chessboard:9x7:0.04mm"), HasSubstr("lie 4e-05 m apart: is the unit right"));
}

TEST_F(BadData, FewViewsAreNamed) {
  EXPECT_THAT(told(world(14).problem), Not(HasSubstr("too few")));
  EXPECT_THAT(told(world(5).problem), HasSubstr("stands on 5 views only, too few"));
}

}  // namespace
}  // namespace raybundle::testing
