// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <functional>
#include <random>

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

// One pattern of images for both cameras gives a perfect pair without a baseline.
TEST_F(BadData, ImagesOfOneCameraGivenAsAnothersAreNamed) {
  CalibrationProblem problem = world().problem;
  problem.cameras.push_back(problem.cameras[0]);
  problem.cameras[1].name = "camera1";
  const std::size_t views = problem.views.size();
  for (std::size_t v = 0; v < views; ++v) {
    TargetView copy = problem.views[v];
    copy.camera = 1;
    problem.views.push_back(copy);
  }
  write_text(place / "same.json", text_from_observations({problem, {}}));
  const ProgramRun run = raybundle_program({"calibrate", "--observations", (place / "same.json").string(), "--model",
                                            "kannala_brandt", "-o", (place / "out").string()});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("warning: camera0 and camera1 have corners at exactly the same pixels in 14 frames"));

  // Saved a second time, with the noise of another compression.
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.05);
  for (std::size_t v = views; v < problem.views.size(); ++v) {
    for (Observation& corner : problem.views[v].observations) {
      corner.pixel += Eigen::Vector2d(noise(random), noise(random));
    }
  }
  write_text(place / "same.json", text_from_observations({problem, {}}));
  const ProgramRun again = raybundle_program({"calibrate", "--observations", (place / "same.json").string(), "--model",
                                              "kannala_brandt", "-o", (place / "out").string()});
  EXPECT_THAT(again.out, HasSubstr("warning: camera0 and camera1 stand in the same place"));
}

TEST_F(BadData, ColumnsInTheWrongOrder) {
  CalibrationProblem problem = world().problem;
  for (TargetView& view : problem.views) {
    for (Observation& corner : view.observations) std::swap(corner.pixel.x(), corner.pixel.y());
  }
  write_text(place / "swapped.csv", csv_of(problem));
  refuses(raybundle_program(arguments("swapped.csv")), {"camera camera0", "u and v were swapped"});
}

// All of them mirrored no residual shows, and no other view.
TEST_F(BadData, PixelsThatCountUpwardsAreWarnedOf) {
  CalibrationProblem problem = world().problem;
  write_text(place / "down.csv", csv_of(problem));
  EXPECT_THAT(raybundle_program(arguments("down.csv")).err, Not(HasSubstr("does v count upwards")));
  for (TargetView& view : problem.views) {
    for (Observation& corner : view.observations) corner.pixel.y() = 959.0 - corner.pixel.y();
  }
  write_text(place / "up.csv", csv_of(problem));
  EXPECT_THAT(raybundle_program(arguments("up.csv")).err, HasSubstr("does v count upwards"));
}

// The views of a problem, some of them spoilt; and the problem without those.
struct SpoiltViews {
  CalibrationProblem problem, without;

  SpoiltViews(const CalibrationProblem& good, const std::vector<std::size_t>& views,
              const std::function<void(TargetView&)>& spoil)
      : problem(good), without(good) {
    for (const std::size_t v : views) spoil(problem.views[v]);
    for (std::size_t v = good.views.size(); v-- > 0;) {
      if (std::ranges::find(views, v) != views.end()) without.views.erase(without.views.begin() + static_cast<int>(v));
    }
  }
};

// Such a view fits as a board seen from behind, so that no residual would show it.
TEST_F(BadData, MirroredViewsAreNamedAndLeftOut) {
  const CalibrationProblem good = world().problem;
  const auto mirror_image = [](TargetView& view) {
    for (Observation& corner : view.observations) corner.pixel.x() = 1279.0 - corner.pixel.x();
  };
  const auto swap_axes = [](TargetView& view) {
    for (Observation& corner : view.observations) corner.pixel = {1.2 * corner.pixel.y(), 0.7 * corner.pixel.x()};
  };
  const auto mirror_board = [](TargetView& view) {
    for (Observation& corner : view.observations) corner.point_id += 8 - 2 * (corner.point_id % 9);
  };
  for (const auto& spoil : std::vector<std::function<void(TargetView&)>>{mirror_image, swap_axes, mirror_board}) {
    const SpoiltViews spoilt(good, {3, 7}, spoil);
    told(spoilt.without);
    const std::string expected = without_provenance(place / "out" / "calibration.json");
    const std::string out = told(spoilt.problem);
    for (const std::size_t v : {3, 7}) {
      EXPECT_THAT(out, HasSubstr("frame " + good.frames[good.views[v].frame] + ": its corners are in mirror order"));
    }
    EXPECT_EQ(without_provenance(place / "out" / "calibration.json"), expected);
  }
}

// A board of 7x5 corners whose corners were numbered as such, among those of the board that was asked for.
TEST_F(BadData, ViewsOfABoardWithOtherRowsAndColumnsAreNamedAndLeftOut) {
  const SpoiltViews spoilt(world().problem, {2, 5, 11}, [](TargetView& view) {
    std::vector<Observation> numbered;
    for (Observation corner : view.observations) {
      const int column = corner.point_id % 9, row = corner.point_id / 9;
      if (column >= 7 || row >= 5) continue;
      corner.point_id = 7 * row + column;
      numbered.push_back(corner);
    }
    view.observations = numbered;
  });
  told(spoilt.without);
  const std::string expected = without_provenance(place / "out" / "calibration.json");
  const std::string out = told(spoilt.problem);
  EXPECT_THAT(out, HasSubstr("its corners do not lie in the order of the board"));
  EXPECT_EQ(without_provenance(place / "out" / "calibration.json"), expected);
}

// A board of three quarters of the size in some frames: to one camera it is as if it were nearer, and nothing is wrong.
TEST_F(BadData, BoardsOfTwoSizesAreNamed) {
  SyntheticOptions options = stereo_head();
  options.noise_px = 0.1;
  options.frames = 12;
  CalibrationProblem mixed = synthetic_world(options).problem;
  options.square_m *= 0.75;
  options.frames = 6;
  options.seed = 2;
  const CalibrationProblem small = synthetic_world(options).problem;
  for (TargetView view : small.views) {
    view.frame += 12;
    mixed.views.push_back(view);
  }
  for (int f = 12; f < 18; ++f) mixed.frames.push_back("small" + std::to_string(f));
  write_text(place / "mixed.csv", csv_of(mixed));
  std::vector<std::string> words = arguments("mixed.csv");
  words.insert(words.end(), {"--image-size", "camera1=1280x960"});
  refuses(raybundle_program(words),
          {"by 6 frames (", "small12", "times what it is by the others", "a board of another size"});
}

TEST_F(BadData, RowsAndColumnsExchangedAreNamed) {
  write_text(place / "corners.csv", csv_of(world().problem));
  refuses(raybundle_program(arguments("corners.csv", "chessboard:7x9:40mm")),
          {"camera camera0: in 14 of 14 views the corners do not lie in the order of", "rows and columns exchanged"});
}

// Of one camera among others they cost that camera only.
TEST_F(BadData, ACameraWithAnotherOrderDoesNotCostTheOthersTheirs) {
  SyntheticOptions options = stereo_head();
  options.noise_px = 0.1;
  CalibrationProblem problem = synthetic_world(options).problem;
  for (TargetView& view : problem.views) {
    if (view.camera == 0) continue;
    for (Observation& corner : view.observations) corner.point_id = corner.point_id % 9 * 7 + corner.point_id / 9;
  }
  write_text(place / "corners.csv", csv_of(problem));
  std::vector<std::string> words = arguments("corners.csv");
  words.insert(words.end(), {"--image-size", "camera1=1280x960"});
  const ProgramRun run = raybundle_program(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("camera camera1: in"));
  const std::string calibration = text_of(place / "out" / "calibration.json");
  EXPECT_THAT(calibration, HasSubstr("\"camera0\""));
  EXPECT_THAT(calibration, Not(HasSubstr("\"camera1\"")));
}

TEST_F(BadData, ABoardInTheWrongUnitIsNamed) {
  const CalibrationProblem problem = world().problem;
  EXPECT_THAT(told(problem), Not(HasSubstr("unit")));
  EXPECT_THAT(told(problem, "chessboard:9x7:40m"), HasSubstr("lie 40 m apart: is the unit right"));
  EXPECT_THAT(told(problem, "chessboard:9x7:0.04mm"), HasSubstr("lie 4e-05 m apart: is the unit right"));
}

// A lattice whose points are the corners of 4x4 tags, as far apart as they are wide.
CalibrationProblem lattice_of_tags() {
  SyntheticOptions options;
  options.columns = options.rows = 8;
  options.frames = 14;
  options.noise_px = 0.1;
  CalibrationProblem problem = synthetic_world(options).problem;
  constexpr int kCornerAt[2][2] = {{0, 1}, {3, 2}};  // anticlockwise
  for (TargetView& view : problem.views) {
    for (Observation& seen : view.observations) {
      const int row = seen.point_id / 8, column = seen.point_id % 8;
      seen.point_id = 4 * (row / 2 * 4 + column / 2) + kCornerAt[row % 2][column % 2];
    }
  }
  return problem;
}

TEST_F(BadData, TagsOfAnotherSizeAreNamedWithTheOneThatFits) {
  const CalibrationProblem problem = lattice_of_tags();
  EXPECT_THAT(told(problem, "aprilgrid:4x4:40mm:1"), Not(HasSubstr("than stated")));
  const std::string larger = told(problem, "aprilgrid:4x4:42mm:0.904762");  // at the same 80 mm from tag to tag
  EXPECT_THAT(larger, HasSubstr("% smaller than stated"));
  EXPECT_THAT(larger, HasSubstr("with a spacing of about 0.99"));  // to first order
  const std::string smaller = told(problem, "aprilgrid:4x4:39.6mm:1.020202");
  EXPECT_THAT(smaller, HasSubstr("1.0 % larger than stated"));
  EXPECT_THAT(smaller, HasSubstr("with a spacing of about 1.00"));
}

// Frames that repeat the first one leave too few views, and the sentence counts what the table holds: no images.
TEST_F(BadData, OneViewAgainAndAgain) {
  CalibrationProblem problem = world(5).problem;
  for (TargetView& view : problem.views) view.observations = problem.views.front().observations;
  write_text(place / "corners.csv", csv_of(problem));
  const ProgramRun run = raybundle_program(arguments("corners.csv"));
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(run.err, HasSubstr("4 of 5 views are left out, such as "));
  EXPECT_THAT(run.err, HasSubstr("shows exactly what frame "));
}

TEST_F(BadData, FewViewsAreNamed) {
  EXPECT_THAT(told(world(14).problem), Not(HasSubstr("too few")));
  EXPECT_THAT(told(world(9).problem), HasSubstr("stands on 9 views only, too few"));
}

// Nothing tests sigmas of fewer than ten frames, so that nothing passes by them.
TEST_F(BadData, NoRequirementPassesOnFewViews) {
  for (const int frames : {9, 14}) {
    write_text(place / "corners.csv", csv_of(world(frames).problem));
    std::vector<std::string> words = arguments("corners.csv");
    words.insert(words.end(), {"--require", "projection 5 px over 40 deg", "--json"});
    const ProgramRun run = raybundle_program(words);
    const nlohmann::json report = nlohmann::json::parse(run.out);
    EXPECT_EQ(report["verdict"]["grade"], frames == 9 ? "marginal" : "pass") << report["verdict"];
    EXPECT_EQ(run.exit_code, 0) << run.err;  // a fail alone is 1
  }
}

}  // namespace
}  // namespace raybundle::testing
