// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "dataset.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "detect_dots.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_kind.hpp"
#include "terminal.hpp"
#include "text_file.hpp"

namespace raybundle::apps {
namespace {

using ::testing::HasSubstr;

Dataset with_board_name(const std::string& name) {
  return dataset_from_text("[target]\n" + name + "kind = \"chessboard\"\ncolumns = 9\nrows = 6\nsquare_m = 0.025\n" +
                               "[[camera]]\nname = \"a\"\nimages = \"*.jpg\"\nmodel = \"pinhole\"\n",
                           "d.toml");
}

TEST(DatasetToml, ABoardsNameIsTextOrLeftOut) {
  EXPECT_EQ(with_board_name("").boards.at(0).name, "board");
  EXPECT_EQ(with_board_name("name = \"wall\"\n").boards.at(0).name, "wall");
  try {
    with_board_name("name = 5\n");
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("d.toml:2: [target].name must be a text in quotes"));
  }
}

std::string documentation() { return text_of(RAYBUNDLE_SOURCE_DIR "/docs/formats/dataset.md"); }

// docs/formats/dataset.md names all options of [calibrate], with their defaults.
TEST(DatasetDocs, NameEveryOptionOfCalibrate) {
  const std::string docs = documentation();
  CalibrateOptions options;
  CalibrateOptions::for_each_option(options, [&](const char* name, const char*, const char*, const auto& value) {
    EXPECT_THAT(docs, HasSubstr(fmt::format("\n{} = {}", name, value)));
  });
}

// Who writes a [target] finds each field there is, in the words that the program has for it.
TEST(DatasetDocs, NameEveryFieldOfEveryBoard) {
  const std::string docs = documentation();
  std::size_t rows = 0, fields = 0;
  for (const BoardKind& kind : board_kinds()) {
    const std::string begin = fmt::format("\n| `{}` | `", kind.name);
    for (std::size_t at = docs.find(begin); at != docs.npos; at = docs.find(begin, at + 1)) ++rows;
    for (const BoardField& field : kind.fields) {
      ++fields;
      EXPECT_THAT(docs, HasSubstr(fmt::format("{}{}`{} | {} |", begin, field.name, field.required ? "" : ", optional",
                                              field.help)));
    }
  }
  EXPECT_EQ(rows, fields) << "a field that is no more";
}

TEST(DatasetDocs, ShowAnExampleThatIsAccepted) {
  const std::string docs = documentation();
  const std::string fence = "```toml\n";
  const std::size_t begin = docs.find(fence) + fence.size();
  const Dataset dataset = dataset_from_text(docs.substr(begin, docs.find("```", begin) - begin), "dataset.md");
  EXPECT_EQ(dataset.cameras.size(), 2u);
  EXPECT_TRUE(dataset.laser && dataset.survey);
}

TEST(ShellWord, IsQuotedWhereAShellWouldTakeItApart) {
  EXPECT_EQ(shell_word("out/a-b_1.json"), "out/a-b_1.json");
  EXPECT_EQ(shell_word("my out"), "'my out'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(AnchorFlag, NamesADotAndItsBeam) {
  const DatasetAnchor anchor = anchor_from_flag("left/12:320.5,240=5,7");
  EXPECT_EQ(anchor.camera, "left");
  EXPECT_EQ(anchor.frame, "12");
  EXPECT_EQ(anchor.pixel, Eigen::Vector2d(320.5, 240));
  EXPECT_EQ(anchor.row, 5);
  EXPECT_EQ(anchor.column, 7);
  EXPECT_EQ(anchor_from_flag("a=b/1:2,3=4,5").camera, "a=b");
  for (const char* flag : {"", "left", "left/12", "/12:1,2=3,4", "left/:1,2=3,4", "left/12:1,2", "left/12:1,2=3",
                           "left/12:1=3,4", "left/12:1,2=3,4,5", "left/12:nan,2=3,4", "left/12:1,2=3.5,4"}) {
    EXPECT_THROW(anchor_from_flag(flag), Error) << flag;
  }
}

// Of two boards in one image the one whose dot was clicked.
TEST(SetAnchor, IsOnTheBoardOfTheNearestDot) {
  CalibrationProblem problem;
  problem.cameras.resize(1);
  problem.cameras[0].name = "left";
  problem.frames = {"12"};
  problem.laser.emplace().grid = {11, 11};
  problem.views.resize(3);
  for (int target = 0; target < 3; ++target) problem.views[target].target = target;
  problem.views[1].dots = {{.pixel = {100, 100}}, {.pixel = {320, 200}}};
  problem.views[2].dots = {{.pixel = {300, 200}}};
  for (const auto& [u, view] : {std::pair(312.0, 1), std::pair(304.0, 2), std::pair(101.0, 1)}) {
    set_anchor({"left", "12", {u, u < 200 ? 101.0 : 202.0}, 5, 7}, problem);
    EXPECT_EQ(problem.laser->anchor->view, view) << u;
  }
}

TEST(RuleFlags, TakeNothingButNumbers) {
  using Kind = ParameterRule::Kind;
  EXPECT_EQ(rule_from_flag(Kind::kFixed, "left.fx=5e2").value, 500.0);
  EXPECT_EQ(rule_from_flag(Kind::kPrior, "left.fx=500:+0.5").sigma, 0.5);
  for (const char* flag : {"left.fx=5x", "left.fx=0x10", "left.fx=+-5", "left.fx=5 ", "left.fx=inf"}) {
    EXPECT_THROW(rule_from_flag(Kind::kFixed, flag), Error) << flag;
  }
  EXPECT_EQ(rule_from_flag(Kind::kFree, "left.fx").pattern, "left.fx");
  EXPECT_THROW(rule_from_flag(Kind::kFree, "left.fx=500"), Error) << "the value would be without effect";
}

}  // namespace
}  // namespace raybundle::apps
