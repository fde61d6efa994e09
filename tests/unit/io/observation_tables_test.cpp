// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/observation_tables.hpp"

#include <cstdlib>
#include <filesystem>

#include "io_examples.hpp"
#include "real_data.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

const std::map<std::string, ImageSize> kSizes{{"left", {640, 480}}, {"right", {320, 240}}};

Target board() { return grid_target("board", 3, 2, 0.05); }

CalibrationProblem from_csv(const std::string& text) {
  return observations_from_csv_text(text, "c.csv", board(), kSizes);
}

std::string csv_message(const std::string& text) {
  return message_of([&] { from_csv(text); });
}

const std::string kHeader = "camera,frame,point_id,u,v,sigma\n";
const std::string kRows = "left,8,0,10.5,20,0.5\nright,8,5,1,2,\nleft,8,1,11,20\nleft,9,0,12,20,1\n";

TEST(ObservationCsv, ReadsWithAndWithoutHeader) {
  for (const std::string& text :
       {kHeader + kRows, kRows, "# made by hand\n\n" + kRows, "\xEF\xBB\xBF" + kHeader + kRows}) {
    const CalibrationProblem problem = from_csv(text);
    ASSERT_EQ(problem.cameras.size(), 2u);
    EXPECT_EQ(problem.cameras[0].name, "left");
    EXPECT_EQ(problem.cameras[1].size, (ImageSize{320, 240}));
    EXPECT_EQ(problem.frames, (std::vector<std::string>{"8", "9"}));
    ASSERT_EQ(problem.views.size(), 3u);
    ASSERT_EQ(problem.views[0].observations.size(), 2u);
    EXPECT_EQ(problem.views[0].observations[0].pixel, Eigen::Vector2d(10.5, 20));
    EXPECT_EQ(problem.views[0].observations[0].sigma_px, 0.5);
    EXPECT_EQ(problem.views[1].observations[0].sigma_px, 1.0);
  }
}

// A line with numbers is no header, whatever its camera is called.
TEST(ObservationCsv, ACameraMayBeCalledAsAColumn) {
  const CalibrationProblem problem =
      observations_from_csv_text("camera,8,0,10.5,20\ncamera,8,1,11,20\n", "c.csv", board(), {{"camera", {640, 480}}});
  EXPECT_EQ(problem.views.at(0).observations.size(), 2u);
}

TEST(ObservationCsv, TheHeaderGivesTheOrder) {
  const CalibrationProblem problem = from_csv("u,v,point_id,camera,frame\r\n1,2,3,left,a\r\n3,4,3,\"right\",a\r\n");
  EXPECT_EQ(problem.views[0].observations[0].pixel, Eigen::Vector2d(1, 2));
  EXPECT_EQ(problem.views[1].observations[0].point_id, 3);
}

TEST(ObservationCsv, EveryComplaintNamesTheLine) {
  EXPECT_THAT(csv_message(""), HasSubstr("c.csv: there are no observations in the file"));
  EXPECT_THAT(csv_message(kHeader), HasSubstr("c.csv: there are no observations in the file"));
  EXPECT_THAT(csv_message("camera,frame,point_id,u\n"), HasSubstr("c.csv:1: the header has no column v; the columns"));
  EXPECT_THAT(csv_message("camera,frame,point_id,u,v,sgma\n"), HasSubstr("c.csv:1: unknown column 'sgma'"));
  EXPECT_THAT(csv_message("camera,frame,point_id,u,v,u\n"), HasSubstr("c.csv:1: column u stands twice"));
  EXPECT_THAT(csv_message(kRows + "left,9\n"), HasSubstr("c.csv:5: 2 fields where 5 to 6 are expected"));
  EXPECT_THAT(csv_message(kRows + "left,9,1,x,2\n"), HasSubstr("c.csv:5: u is 'x', which is not a finite number"));
  EXPECT_THAT(csv_message(kRows + "left,9,1,nan,2\n"), HasSubstr("c.csv:5: u is 'nan', which is not a finite number"));
  EXPECT_THAT(csv_message(kRows + "left,9,1,1,inf\n"), HasSubstr("c.csv:5: v is 'inf', which is not a finite"));
  EXPECT_THAT(csv_message(kRows + "left,9,1.5,1,1\n"), HasSubstr("c.csv:5: point_id is '1.5', which is not a whole"));
  EXPECT_THAT(csv_message(kRows + "left,9,1,1,1,0\n"), HasSubstr("c.csv:5: sigma is 0; it must be positive"));
  EXPECT_THAT(csv_message(kRows + "left,9,6,1,1\n"), HasSubstr("c.csv:5: point 6 is not on the board, which has 6"));
  EXPECT_THAT(csv_message(kRows + "left,9,0,1,1\n"), HasSubstr("c.csv:5: the camera observes this point a second"));
  EXPECT_THAT(csv_message(kRows + "lefft,9,1,1,1\n"), HasSubstr("camera 'lefft' is not given; give it as NAME=WIDTH"));
  EXPECT_THAT(csv_message("left,8,0,1,1\n"), HasSubstr("given for camera 'right', which has no observations"));
  EXPECT_THAT(csv_message(kRows + "left,10,0,5000,1\n"),
              HasSubstr("frame 10: point 0 lies far outside of the 640x480"));
  EXPECT_THAT(csv_message("\"left,8,0,1,1\n"), HasSubstr("c.csv:1: a double quote is opened but not closed"));
  EXPECT_THAT(csv_message(std::string(100, ',')), HasSubstr("c.csv:1: more than 64 fields in one line"));
}

std::vector<VnlCamera> vnl_cameras() {
  return {{"left", {"*-cam0.jpg"}, {640, 480}}, {"right", {"*-cam1.jpg"}, {640, 480}}};
}

std::string vnl_image(const std::string& name, const std::vector<std::string>& rows) {
  std::string text;
  for (const std::string& row : rows) text += name + " " + row + "\n";
  return text;
}

const std::vector<std::string> kVnlRows{"10 20 0", "11 20 1", "12 20 -", "- - -", "10 30 2", "11 30 -1"};

CalibrationProblem from_vnl(const std::string& text) {
  return observations_from_vnl_text(text, "c.vnl", board(), vnl_cameras());
}

std::string vnl_message(const std::string& text) {
  return message_of([&] { from_vnl(text); });
}

TEST(ObservationVnl, LevelsBecomeSigmasAndMissingPointsAreLeftOut) {
  const CalibrationProblem problem = from_vnl(
      "## generated\n# filename x y level\n" + vnl_image("a/frame03-cam0.jpg", kVnlRows) +
      vnl_image("a/frame12-cam0.jpg", kVnlRows) + "a/frame13-cam0.jpg - - -\n" +
      vnl_image("b/frame12-cam1.jpg", kVnlRows) + "b/frame13-cam1.jpg - - -\n" + vnl_image("b/other.png", {"1 2 0"}));
  EXPECT_EQ(problem.cameras[1].name, "right");
  EXPECT_EQ(problem.frames, (std::vector<std::string>{"3", "12"}));
  ASSERT_EQ(problem.views.size(), 3u);
  const TargetView& view = problem.views[0];
  EXPECT_EQ(view.image, "a/frame03-cam0.jpg");
  ASSERT_EQ(view.observations.size(), 3u);
  EXPECT_EQ(view.observations[0].sigma_px, 1.0);
  EXPECT_EQ(view.observations[1].sigma_px, 2.0);
  EXPECT_EQ(view.observations[2].sigma_px, 4.0);
  EXPECT_EQ(view.observations[2].point_id, 4);
  EXPECT_EQ(problem.views[2].camera, 1);
}

TEST(ObservationVnl, WeightsAreInverseSigmas) {
  const std::string one = "# filename x y weight\n" +
                          vnl_image("1-cam0.jpg", {"1 2 0.5", "2 2 4", "3 2 0", "1 3 1", "2 3 1", "3 3 1"}) +
                          vnl_image("1-cam1.jpg", kVnlRows);
  const CalibrationProblem problem = from_vnl(one);
  ASSERT_EQ(problem.views[0].observations.size(), 5u);
  EXPECT_EQ(problem.views[0].observations[0].sigma_px, 2.0);
  EXPECT_EQ(problem.views[0].observations[1].sigma_px, 0.25);
}

TEST(ObservationVnl, EveryComplaintNamesTheLine) {
  const std::string good = vnl_image("1-cam0.jpg", kVnlRows) + vnl_image("1-cam1.jpg", kVnlRows);
  EXPECT_THAT(vnl_message("# filename x y level\n"), HasSubstr("c.vnl: there are no corners in the file"));
  EXPECT_THAT(vnl_message("# filename y x\n" + good), HasSubstr("c.vnl:1: the columns must be `filename x y level`"));
  EXPECT_THAT(vnl_message(good + "2-cam0.jpg 1\n"), HasSubstr("c.vnl:13: this line has 2 words where"));
  EXPECT_THAT(vnl_message(good + "2-cam0.jpg 1 a 0\n"),
              HasSubstr("c.vnl:13: y is 'a', which is neither a number nor -"));
  EXPECT_THAT(vnl_message(good + "2-cam0.jpg 1 2 nan\n"), HasSubstr("c.vnl:13: level is 'nan', which is neither"));
  EXPECT_THAT(vnl_message(good + vnl_image("2-cam0.jpg", {"1 2 0", "3 4 0"})),
              HasSubstr("c.vnl:13: image '2-cam0.jpg' has 2 lines, but the board has 6 points"));
  EXPECT_THAT(
      vnl_message(vnl_image("1-cam0.jpg", kVnlRows)),
      HasSubstr("no image matches '*-cam1.jpg' of camera 'right'; the first image of the file is '1-cam0.jpg'"));
  std::vector<VnlCamera> both = vnl_cameras();
  both[1].images = {"*"};
  EXPECT_THAT(
      message_of([&] { observations_from_vnl_text(good, "c.vnl", board(), both); }),
      HasSubstr("image '1-cam0.jpg' matches both camera 'left' and camera 'right'; make the patterns narrower"));
}

// Of a camera whose images lie in several folders, those of the first were taken once and the others left out.
TEST(ObservationVnl, ACameraMayHaveSeveralPatterns) {
  const std::string text = vnl_image("day1/1-cam0.jpg", kVnlRows) + vnl_image("day2/2-cam0.jpg", kVnlRows);
  const auto views = [&](const std::vector<std::string>& patterns) {
    return observations_from_vnl_text(text, "c.vnl", board(), {{"left", patterns, {640, 480}}}).views.size();
  };
  EXPECT_EQ(views({"day1/*", "day2/*"}), 2u);
  EXPECT_EQ(views({"day1/*"}), 1u);
  EXPECT_THAT(message_of([&] { views({"day1/*", "day3/*"}); }), HasSubstr("no image matches 'day3/*'"));
}

TEST(ObservationVnl, ReadsAFileThatMrcalMade) {
  const auto path = testing::real_data("mrcal_ultrawide/synthetic-board-observations.vnl");
  if (!std::filesystem::exists(path))
    GTEST_SKIP() << "there is no " << path << "; set RAYBUNDLE_DATA to read real data";
  const std::vector<VnlCamera> cameras{{"cam0", {"*-cam0.xxx"}, {6000, 3376}}, {"cam1", {"*-cam1.xxx"}, {6000, 3376}}};
  const CalibrationProblem problem = read_observations_vnl(path, grid_target("board", 10, 10, 0.1), cameras);
  EXPECT_EQ(problem.frames, (std::vector<std::string>{"0", "1", "2"}));  // made with 3 frames of a 10x10 board
  ASSERT_EQ(problem.views.size(), 6u);
  EXPECT_EQ(problem.views[0].observations[1].pixel, Eigen::Vector2d(1095.337, 1208.062));
}

}  // namespace
}  // namespace raybundle::testing
