// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "fresh_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

using testing::HasSubstr;

std::string message_of(const std::string& word) {
  try {
    board_from_word(word);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << word;
    return error.what();
  }
  ADD_FAILURE() << word << " was accepted";
  return "";
}

TEST(BoardWord, NamesEveryFieldOfAChessboard) {
  const auto board = std::get<Chessboard>(board_from_word("chessboard:9x6:25mm"));
  EXPECT_EQ(board.columns, 9);
  EXPECT_EQ(board.rows, 6);
  EXPECT_EQ(board.square_m, 0.025);
}

TEST(BoardWord, NamesEveryFieldOfACharucoBoard) {
  const auto board = std::get<Charuco>(board_from_word("charuco:8x7:25.4mm:19.05mm:DICT_4X4_1000:inverted:legacy"));
  EXPECT_EQ(board.columns, 8);
  EXPECT_EQ(board.rows, 7);
  EXPECT_EQ(board.square_m, 0.0254);
  EXPECT_EQ(board.marker_m, 0.01905);
  EXPECT_EQ(board.dictionary, "DICT_4X4_1000");
  EXPECT_TRUE(board.legacy);
  EXPECT_TRUE(board.inverted);
}

TEST(BoardWord, AprilGridIsKalibrsUnlessTheWordSaysOtherwise) {
  const auto kalibr = std::get<AprilGrid>(board_from_word("aprilgrid:6x5:88mm:0.3"));
  EXPECT_EQ(kalibr.columns, 6);
  EXPECT_EQ(kalibr.rows, 5);
  EXPECT_EQ(kalibr.tag_m, 0.088);
  EXPECT_EQ(kalibr.spacing, 0.3);
  EXPECT_EQ(kalibr.family, "36h11");
  EXPECT_EQ(kalibr.border_bits, 2);
  const auto other = std::get<AprilGrid>(board_from_word("aprilgrid:4x3:50mm:0.25:1bit:25h9:first_tag=7"));
  EXPECT_EQ(other.family, "25h9");
  EXPECT_EQ(other.border_bits, 1);
  EXPECT_EQ(other.first_tag, 7);
}

TEST(BoardWord, KnowsFourUnitsOfLength) {
  for (const char* word : {"circles:7x7:25.4mm", "circles:7x7:2.54cm", "circles:7x7:1in", "circles:7x7:0.0254m"}) {
    EXPECT_EQ(std::get<Circles>(board_from_word(word)).spacing_m, 0.0254) << word;
  }
}

TEST(BoardWord, GivesBackTheSameWord) {
  for (const char* word : {"chessboard:9x6:25mm", "chessboard:9x6:24.23mm", "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000",
                           "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000:legacy:inverted", "aprilgrid:6x6:88mm:0.3",
                           "aprilgrid:6x6:88mm:0.3:25h9:1bit", "aprilgrid:5x7:40mm:0.25:DICT_6X6_250:1bit:top_down",
                           "aprilgrid:2x2:88mm:0.3:first_tag=36", "circles:7x7:20mm", "asymmetric_circles:4x11:20mm",
                           "asymmetric_circles:4x11:20mm:row_step=35mm"}) {
    // Families have different sizes: 25h9 has 35 tags only.
    if (std::string(word).find("6x6:88mm:0.3:25h9") != std::string::npos) continue;
    EXPECT_EQ(word_of(board_from_word(word)), word);
  }
  for (const BoardKind& kind : board_kinds()) {
    if (kind.name == "points") continue;  // its example names a file
    EXPECT_EQ(word_of(board_from_word(kind.example)), kind.example);
  }
}

TEST(BoardWord, GivesBackEveryLengthBitByBit) {
  double length_m = 0.0123456789;
  for (int i = 0; i < 200; ++i, length_m *= 1.0371) {
    const Board board = Chessboard{9, 6, length_m};
    EXPECT_EQ(std::get<Chessboard>(board_from_word(word_of(board))).square_m, length_m) << word_of(board);
  }
}

TEST(BoardWord, WritesMillimetresForTheLengthsThatFilesHold) {
  for (int tenths = 1; tenths < 3000; ++tenths) {
    const double length_m = std::stod(std::to_string(tenths) + "e-4");
    EXPECT_THAT(word_of(Chessboard{9, 6, length_m}), testing::EndsWith("mm"));
  }
}

TEST(BoardWord, ReadsAPointList) {
  const std::string path = (fresh_folder() / "points.csv").string();
  std::ofstream(path) << "point_id,x,y,z\n7,0.1,0.2,0.3\n3,0,0,0\n4,1,0,0\n5,0,1,0\n";
  const Board board = board_from_word("points:" + path);
  EXPECT_EQ(word_of(board), "points:" + path);
  const Target target = target_of(board);
  ASSERT_EQ(target.points.size(), 4u);
  EXPECT_EQ(target.points[0].id, 3);
  EXPECT_EQ(target.find(7)->x_in_target, Eigen::Vector3d(0.1, 0.2, 0.3));
}

TEST(BoardWord, PointListErrorsNameTheLine) {
  const std::string path = (fresh_folder() / "points.csv").string();
  std::ofstream(path) << "point_id,x,y,z\n0,0.1,0.2,0.3\n1,0,zero,0\n";
  EXPECT_THAT(message_of("points:" + path), HasSubstr(path + ":3"));
  std::ofstream(path) << "0,0,0,0\n1,1,0,0\n2,0,1,0\n1,1,1,0\n";
  EXPECT_THAT(message_of("points:" + path), HasSubstr("point_id 1 stands twice"));
  try {
    board_from_word("points:no/such/file.csv");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kIo);
  }
}

TEST(BoardWord, ErrorsShowTheRightForm) {
  EXPECT_THAT(message_of("chessboard:9x6:25"), HasSubstr("\"25\" has no unit (mm, cm, m, in)"));
  EXPECT_THAT(message_of("chessboard:9x6:25"),
              HasSubstr("write chessboard:COLUMNSxROWS:SQUARE, as chessboard:9x6:25mm"));
  EXPECT_THAT(message_of("chessboard"), HasSubstr("columns is missing (inner corners in a row)"));
  EXPECT_THAT(message_of("chessboard:9x6"), HasSubstr("square_m is missing"));
  EXPECT_THAT(message_of("chessboard:9:25mm"), HasSubstr("\"9\" is not COLUMNSxROWS"));
  EXPECT_THAT(message_of("chessboard:9x6:25mm:"), HasSubstr("means nothing here"));
  EXPECT_THAT(message_of("chessbord:9x6:25mm"), HasSubstr("Did you mean \"chessboard\"?"));
  EXPECT_THAT(message_of("charuco:8x8:25mm:19mm:DICT_4X4_100:legasy"), HasSubstr("did you mean \"legacy\""));
  EXPECT_THAT(message_of("charuco:8x8:25mm:19mm:4X4_1000"), HasSubstr("did you mean \"DICT_4X4_1000\""));
  EXPECT_THAT(message_of("charuco:8x8:25mm:19mm:DICT_4X4_100:legacy:legacy"), HasSubstr("sets legacy again"));
  EXPECT_THAT(message_of("aprilgrid:6x6:88mm:0.3:1bits"), HasSubstr("means nothing here"));
  EXPECT_THAT(message_of(""), HasSubstr("chessboard, charuco, aprilgrid"));
  EXPECT_THAT(message_of(":"), HasSubstr("the board's kind is missing"));
}

TEST(BoardWord, RefusesBoardsThatCannotBe) {
  EXPECT_THAT(message_of("chessboard:1x6:25mm"), HasSubstr("at least 2, not 1x6"));
  EXPECT_THAT(message_of("chessboard:-9x6:25mm"), HasSubstr("at least 2"));
  EXPECT_THAT(message_of("chessboard:999999x999999:25mm"), HasSubstr("more than any board has"));
  EXPECT_THAT(message_of("chessboard:9x6:0mm"), HasSubstr("square_m must be a positive length"));
  EXPECT_THAT(message_of("chessboard:9x6:nanmm"), HasSubstr("is not a length with its unit"));
  EXPECT_THAT(message_of("charuco:8x8:25mm:25mm:DICT_4X4_100"), HasSubstr("must be smaller than square_m"));
  EXPECT_THAT(message_of("charuco:12x12:25mm:19mm:DICT_4X4_50"), HasSubstr("needs 72 markers"));
  EXPECT_THAT(message_of("aprilgrid:6x6:88mm:0.3:25h9"), HasSubstr("family 25h9 has codes 0 to 34"));
  EXPECT_THAT(message_of("aprilgrid:6x6:88mm:-1"), HasSubstr("gap between tags over the tag's size"));
  EXPECT_THAT(message_of("aprilgrid:6x6:88mm:0.3:3bit"), HasSubstr("border_bits must be 2"));
}

}  // namespace
}  // namespace raybundle
