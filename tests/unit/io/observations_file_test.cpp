// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/observations_file.hpp"

#include "io_examples.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string read_message(const std::string& text) {
  return message_of([&] { observations_from_text(text, "o.json"); });
}

// A file as a person would write it: no frames, no sigma, one target.
std::string short_file() {
  return R"({
"format": "raybundle observations", "version": 1,
"targets": [{"name": "board", "points": [[0,0,0,0], [1,0.1,0,0], [2,0,0.1,0], [5,0.1,0.1,0]]}],
"cameras": [{"name": "left", "width": 640, "height": 480, "model": "pinhole"},
            {"name": "right", "width": 320, "height": 240}],
"views": [
{"camera": "left", "frame": "8", "points": [[0,10,20],[5,11.5,20,0.5]]},
{"camera": "right", "frame": "8", "target": 0, "image": "right08.png", "points": [[1,30,40]]},
{"camera": "left", "frame": "9", "points": []}
]})";
}

TEST(ObservationsFile, SaveAndLoadIsTheIdentity) {
  const ObservationsFile saved = small_observations();
  const ObservationsFile loaded = observations_from_text(text_from_observations(saved), "o.json");
  EXPECT_EQ(text_from_observations(saved), text_from_observations(loaded));
  EXPECT_EQ(saved.problem.frames, loaded.problem.frames);
  EXPECT_EQ(saved.models, loaded.models);
  ASSERT_EQ(saved.problem.views.size(), loaded.problem.views.size());
  for (std::size_t i = 0; i < saved.problem.views.size(); ++i) {
    const TargetView& a = saved.problem.views[i];
    const TargetView& b = loaded.problem.views[i];
    EXPECT_EQ(std::tie(a.camera, a.frame, a.target, a.image), std::tie(b.camera, b.frame, b.target, b.image));
    ASSERT_EQ(a.observations.size(), b.observations.size());
    for (std::size_t k = 0; k < a.observations.size(); ++k) {
      EXPECT_EQ(a.observations[k].point_id, b.observations[k].point_id);
      EXPECT_EQ(a.observations[k].pixel, b.observations[k].pixel);
      EXPECT_EQ(a.observations[k].sigma_px, b.observations[k].sigma_px);
    }
    ASSERT_EQ(a.dots.size(), b.dots.size());
    for (std::size_t k = 0; k < a.dots.size(); ++k) {
      EXPECT_EQ(a.dots[k].pixel, b.dots[k].pixel);
      EXPECT_EQ(a.dots[k].covariance_px2, b.dots[k].covariance_px2);
      EXPECT_EQ(a.dots[k].beam, b.dots[k].beam);
      EXPECT_EQ(a.dots[k].brightness, b.dots[k].brightness);
    }
  }
}

TEST(ObservationsFile, DotsNeedNoLabelAndNoBrightness) {
  const std::string laser = replaced(short_file(), "\"views\"", "\"laser\": {\"rows\": 2, \"columns\": 3},\n\"views\"");
  const auto with_dots = [&](const std::string& dots) {
    return replaced(laser, "\"points\": []", "\"points\": [], \"dots\": " + dots);
  };
  const ObservationsFile file = observations_from_text(
      with_dots("[[1,2,0.1,0,0.2],[3,4,0.1,0,0.2,null,null],[5,6,0.1,0,0.2,1,2],[7,8,0.1,0,0.2,0,1,99]]"), "o.json");
  const std::vector<Dot>& dots = file.problem.views[2].dots;
  ASSERT_EQ(dots.size(), 4u);
  EXPECT_EQ(dots[0].beam, kUnlabelled);
  EXPECT_EQ(dots[1].beam, kUnlabelled);
  EXPECT_EQ(dots[2].beam, 5);
  EXPECT_EQ(dots[3].brightness, 99);
  EXPECT_EQ(file.problem.laser->grid.size(), 6);
  EXPECT_THAT(read_message(with_dots("[[1,2,0.1,0]]")), HasSubstr("views[2].dots[0] has 4 entries"));
  EXPECT_THAT(read_message(with_dots("[[1,2,0.1,0,0.2,1,null]]")), HasSubstr("has a row or a column, but not both"));
  EXPECT_THAT(read_message(with_dots("[[1,2,0.1,0,0.2,2,0]]")), HasSubstr("whole number from 0 to 1"));
  EXPECT_THAT(read_message(with_dots("[[1,2,0.1,9,0.2]]")), HasSubstr("positive definite"));
  EXPECT_THAT(read_message(replaced(short_file(), "\"points\": []", "\"points\": [], \"dots\": []")),
              HasSubstr("views[2].dots are there, but the file has no laser"));
}

TEST(ObservationsFile, EveryViewIsOneLine) {
  const std::string text = text_from_observations(small_observations());
  EXPECT_THAT(text, HasSubstr("\n    {\"camera\":\"camera0\",\"frame\":\"0\",\"target\":0,\"points\":[[0,"));
}

TEST(ObservationsFile, FramesSigmaTargetAndModelMayBeMissing) {
  const ObservationsFile file = observations_from_text(short_file(), "o.json");
  EXPECT_EQ(file.problem.frames, (std::vector<std::string>{"8", "9"}));
  EXPECT_EQ(file.models, (std::vector<std::optional<ModelId>>{model_named("pinhole"), std::nullopt}));
  ASSERT_EQ(file.problem.views.size(), 3u);
  EXPECT_EQ(file.problem.views[0].observations[0].sigma_px, 1.0);
  EXPECT_EQ(file.problem.views[0].observations[1].sigma_px, 0.5);
  EXPECT_EQ(file.problem.views[1].image, "right08.png");
}

// Views are read one by one: a text that breaks off among them has no end of them.
TEST(ObservationsFile, BrokenTextAmongViewsIsNamed) {
  EXPECT_THAT(read_message("{\"views\": [{\"camera\": \"left\"},\n{\"camera\" 5}]}"),
              StartsWith("o.json:2: this is not valid JSON"));
  EXPECT_THAT(read_message("{\"views\": [{\"camera\": \"left\"},\n{\"camera\""),
              StartsWith("o.json:2: the JSON text ends too early"));
}

TEST(ObservationsFile, EveryComplaintNamesLineAndKey) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"\"camera\": \"right\"", "\"camera\": \"rigt\"",
       "o.json:8: views[1].camera names 'rigt', which does not exist. Did you mean \"right\"?"},
      {"\"frame\": \"9\"", "\"frane\": \"9\"", "o.json:9: views[2].frane is not a key that belongs here. Did you mean"},
      {"\"frame\": \"9\"", "\"frame\": 9", "o.json:9: views[2].frame is a number, where a text in quotes is expected"},
      {"\"frame\": \"9\"", "\"frame\": \"\"", "o.json:9: views[2].frame is empty; give it a name"},
      {"\"frame\": \"9\"", "\"frame\": \"8\"", "o.json: camera left, frame 8: the view is given twice"},
      {"\"target\": 0", "\"target\": 1", "o.json:8: views[1].target is 1; it must be a whole number from 0 to 0"},
      {"[1,30,40]", "[1,30]", "o.json:8: views[1].points[0] has 2 entries; [id, u, v] or [id, u, v, sigma]"},
      {"[1,30,40]", "[3,30,40]", "views[1].points[0] is point 3, which target 'board' does not have"},
      {"[1,30,40]", "[1,30,40],[1,30,40]", "views[1].points[1] is point 1 again; give each point once a view"},
      {"[1,30,40]", "[1,30,4000]", "o.json: camera right, frame 8: point 1 lies far outside of the 320x240 image"},
      {"[1,30,40]", "[-1,30,40]", "views[1].points[0][0] is -1; it must be a whole number from 0"},
      {"20,0.5]", "20,0]", "o.json:7: views[0].points[1][3] is 0; it must be positive"},
      {"\"views\"", "\"veiws\"", "veiws is not a key that belongs here. Did you mean \"views\"?"},
      {"\"model\": \"pinhole\"", "\"model\": \"pinhol\"", "o.json:4: cameras[0].model 'pinhol' is not a camera model"},
      {"\"right\", \"width\"", "\"left\", \"width\"", "o.json:5: cameras[1].name 'left' stands twice; rename one"},
      {"[[0,0,0,0], [1,0.1,0,0]", "[[1,0,0,0], [0,0.1,0,0]", "targets[0].points[1] has id 0 after 1; sort"},
      {", [5,0.1,0.1,0]", "", "o.json:7: views[0].points[1] is point 5, which target 'board' does not have"},
  };
  for (const Case& c : cases) EXPECT_THAT(read_message(replaced(short_file(), c.from, c.to)), HasSubstr(c.message));
}

}  // namespace
}  // namespace raybundle::testing
