// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "fresh_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_file.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string message_of(const std::string& text) {
  try {
    board_from_toml_text(text, "dataset.toml");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput) << text;
    return error.what();
  }
  ADD_FAILURE() << "accepted: " << text;
  return "";
}

TEST(BoardToml, ReadsTheDocumentedSection) {
  const Board board = board_from_toml_text(
      "[target]\nkind = \"chessboard\"  # chessboard | aprilgrid\ncolumns = 9  # inner corners\nrows = 6\n"
      "square_m = 0.025\n[[camera]]\nname = \"left\"\n",
      "dataset.toml");
  EXPECT_EQ(word_of(board), "chessboard:9x6:25mm");
}

TEST(BoardToml, GivesBackEveryKind) {
  for (const char* word : {"chessboard:9x6:24.23mm", "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000:legacy:inverted",
                           "aprilgrid:6x6:88mm:0.3", "aprilgrid:5x6:88mm:0.3:25h9:1bit:first_tag=2", "circles:7x7:20mm",
                           "asymmetric_circles:4x11:20mm:row_step=35mm"}) {
    EXPECT_EQ(word_of(board_from_toml_text(toml_of(board_from_word(word)), "board.toml")), word);
  }
}

TEST(BoardToml, WholeNumbersAreLengthsToo) {
  const Board board =
      board_from_toml_text("[target]\nkind=\"circles\"\ncolumns=7\nrows=7\nspacing_m=1\n", "board.toml");
  EXPECT_EQ(std::get<Circles>(board).spacing_m, 1.0);
}

TEST(BoardToml, AWrittenFileIsReadAgain) {
  const std::filesystem::path folder = fresh_folder();
  std::filesystem::create_directories(folder / "points");
  std::ofstream(folder / "points/nine \"a\".csv") << "0,0,0,0\n1,1,0,0\n2,0,1,0\n3,1,1,0.5\n";
  for (const Board& board : {board_from_word("chessboard:9x6:25mm"),
                             board_from_word("points:" + (folder / "points/nine \"a\".csv").string())}) {
    write_board_toml(board, folder / "board.toml");
    EXPECT_EQ(word_of(read_board_toml(folder / "board.toml")), word_of(board));
    EXPECT_EQ(target_of(read_board_toml(folder / "board.toml")).points.size(), target_of(board).points.size());
  }
}

TEST(BoardToml, ErrorsNameLineAndField) {
  const std::string start = "# a board\n[target]\nkind = \"chessboard\"\n";
  EXPECT_THAT(message_of(start + "columns = 9\nrows = 6\n"), HasSubstr("dataset.toml:2: [target] has no square_m"));
  EXPECT_THAT(message_of(start + "colums = 9\nrows = 6\n"),
              HasSubstr("dataset.toml:4: [target] has an unknown field 'colums'. Did you mean \"columns\"?"));
  EXPECT_THAT(message_of(start + "columns = 9.5\nrows = 6\nsquare_m = 0.025"),
              HasSubstr("dataset.toml:4: columns must be a whole number"));
  EXPECT_THAT(message_of(start + "columns = 9\nrows = 6\nsquare_m = \"25mm\""),
              HasSubstr("dataset.toml:6: square_m must be a number (metres)"));
  EXPECT_THAT(message_of(start + "columns = 9\nrows = 1\nsquare_m = 0.025"), HasSubstr("at least 2, not 9x1"));
  EXPECT_THAT(message_of("[target]\nkind = \"chesboard\"\n"), HasSubstr("dataset.toml:2: there is no kind of board"));
  EXPECT_THAT(message_of("[target]\nkind = 3\n"), HasSubstr("dataset.toml:2: kind must be a text"));
  EXPECT_THAT(message_of("[target]\ncolumns = 3\n"), HasSubstr("dataset.toml:1: [target] has no kind"));
  EXPECT_THAT(message_of("[camera]\n"), HasSubstr("there is no [target] section"));
  EXPECT_THAT(message_of("[target]\nkind = \"chess\nboard\"\n"), StartsWith("dataset.toml:2: is not TOML"));
}

TEST(BoardToml, AMissingFileIsNamed) {
  try {
    read_board_toml("no/such/board.toml");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kIo);
    EXPECT_THAT(error.what(), HasSubstr("no/such/board.toml"));
  }
}

}  // namespace
}  // namespace raybundle
