// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <regex>

#include "fresh_folder.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/atomic_file.hpp"
#include "raybundle/targets/draw.hpp"

namespace raybundle {
namespace {

using testing::HasSubstr;

constexpr double kTolerance_mm = 0.1;  // what a careful reader can see on a steel rule

// Where a line of pixels crosses from one half of the grey range to the other [px], to a fraction of a pixel.
std::vector<double> edges_along(const cv::Mat& line) {
  std::vector<double> edges;
  const auto at = [&](int i) { return static_cast<double>(line.at<unsigned char>(i)); };
  for (int i = 0; i + 1 < static_cast<int>(line.total()); ++i) {
    if ((at(i) < 127.5) != (at(i + 1) < 127.5)) edges.push_back(i + (127.5 - at(i)) / (at(i + 1) - at(i)));
  }
  return edges;
}

// The page as an independent program sees it.
cv::Mat rendered_pdf(const Drawing& drawing, int dpi) {
  const std::string stem = (fresh_folder() / "page").string();
  write_file_whole(stem + ".pdf", drawing.bytes);
  const std::string command = "pdftoppm -gray -r " + std::to_string(dpi) + " -singlefile " + stem + ".pdf " + stem;
  if (std::system(command.c_str()) != 0) return {};
  return cv::imread(stem + ".pgm", cv::IMREAD_GRAYSCALE);
}

std::string message_of(const Board& board, const DrawOptions& options) {
  try {
    draw(board, DrawingFormat::kPdf, options);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
    return error.what();
  }
  ADD_FAILURE() << "drawn";
  return "";
}

// Of an SVG path of straight lines.
double width_of_path(const std::string& path) {
  std::istringstream tokens(path);
  double low = 1e9;
  double high = -1e9;
  for (std::string token; tokens >> token;) {
    if (token == "Z" || token == "M" || token == "L" || token == "C") continue;
    const double x = std::stod(token);
    tokens >> token;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  return high - low;
}

class DrawnPdf : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("pdftoppm -v > /dev/null 2>&1") != 0) GTEST_SKIP() << "pdftoppm (poppler-utils) is not installed";
  }
};

TEST_F(DrawnPdf, HasSquaresOfTrueSize) {
  constexpr int kDpi = 300;
  const cv::Mat page = rendered_pdf(draw(board_from_word("chessboard:9x6:25mm"), DrawingFormat::kPdf), kDpi);
  ASSERT_FALSE(page.empty());
  const double mm = kDpi / 25.4;
  EXPECT_NEAR(page.cols / mm, 297.0, kTolerance_mm);
  EXPECT_NEAR(page.rows / mm, 210.0, kTolerance_mm);
  // The board stands in the middle of the page's width; a line through its second row of squares meets every edge.
  const double top = edges_along(page.col(static_cast<int>(page.cols / 2.0 + 12.0 * mm)).clone().reshape(0, 1)).front();
  const auto edges = edges_along(page.row(static_cast<int>(top + 37.0 * mm)));
  ASSERT_GE(edges.size(), 10u);
  for (size_t i = 0; i + 1 < edges.size(); ++i) EXPECT_NEAR((edges[i + 1] - edges[i]) / mm, 25.0, kTolerance_mm);
  EXPECT_NEAR((edges.back() - edges.front()) / mm, 25.0 * static_cast<double>(edges.size() - 1), kTolerance_mm);
}

TEST_F(DrawnPdf, HasARulerOf100Millimetres) {
  constexpr int kDpi = 600;
  for (const char* word : {"chessboard:9x6:25mm", "circles:3x3:10mm"}) {
    DrawOptions options;
    options.paper = "fit";
    const cv::Mat page = rendered_pdf(draw(board_from_word(word), DrawingFormat::kPdf, options), kDpi);
    ASSERT_FALSE(page.empty());
    // The ruler's base line is the longest run of ink in the strip below the board.
    const double mm = kDpi / 25.4;
    double longest = 0.0;
    for (int row = page.rows - static_cast<int>(21.0 * mm); row < page.rows - static_cast<int>(10.0 * mm); ++row) {
      const auto edges = edges_along(page.row(row));
      if (edges.size() == 2) longest = std::max(longest, edges[1] - edges[0]);
    }
    EXPECT_NEAR(longest / mm, 100.0, kTolerance_mm) << word;
  }
}

TEST_F(DrawnPdf, HasCirclesAtTrueDistance) {
  constexpr int kDpi = 300;
  const cv::Mat page = rendered_pdf(draw(board_from_word("circles:7x7:20mm"), DrawingFormat::kPdf), kDpi);
  ASSERT_FALSE(page.empty());
  const double mm = kDpi / 25.4;
  // Through the middle column of discs: their centres are 20 mm apart, their diameter is half of that.
  const auto edges = edges_along(page.col(page.cols / 2).clone().reshape(0, 1));
  ASSERT_GE(edges.size(), 14u);
  for (int disc = 0; disc < 7; ++disc) {
    EXPECT_NEAR((edges[2 * disc + 1] - edges[2 * disc]) / mm, 10.0, kTolerance_mm);
    EXPECT_NEAR((edges[2 * disc] + edges[2 * disc + 1] - edges[0] - edges[1]) / 2 / mm, 20.0 * disc, kTolerance_mm);
  }
}

// Not checked: that a browser keeps to the millimetres that the file states.
TEST(DrawnSvg, IsInMillimetres) {
  const Drawing drawing = draw(board_from_word("chessboard:9x6:25mm"), DrawingFormat::kSvg);
  EXPECT_THAT(drawing.bytes, HasSubstr("width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""));
  // The board is the widest path of the file; its coordinates are the page's millimetres.
  double widest = 0.0;
  for (size_t at = 0; (at = drawing.bytes.find(" d=\"", at)) != std::string::npos; ++at) {
    const size_t start = at + 4;
    widest = std::max(widest, width_of_path(drawing.bytes.substr(start, drawing.bytes.find('"', start) - start)));
  }
  EXPECT_NEAR(widest, 250.0, kTolerance_mm);
}

TEST(DrawnPng, HasWholePixelsInEverySquare) {
  DrawOptions options;
  options.square_px = 40;
  const Drawing drawing = draw(board_from_word("chessboard:9x6:25mm"), DrawingFormat::kPng, options);
  const std::vector<unsigned char> bytes(drawing.bytes.begin(), drawing.bytes.end());
  const cv::Mat image = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(image.size(), cv::Size(12 * 40, 9 * 40));  // 10 x 7 squares and one of margin
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const int i = column / 40 - 1;
      const int j = row / 40 - 1;
      const bool black = i >= 0 && i < 10 && j >= 0 && j < 7 && (i + j) % 2 == 0;
      ASSERT_EQ(image.at<unsigned char>(row, column), black ? 0 : 255) << row << " " << column;
    }
  }
}

TEST(DrawnPng, OfADpiHasThePagesSize) {
  DrawOptions options;
  options.dpi = 100;
  options.paper = "letter";
  const Drawing drawing = draw(board_from_word("circles:5x4:20mm"), DrawingFormat::kPng, options);
  const std::vector<unsigned char> bytes(drawing.bytes.begin(), drawing.bytes.end());
  EXPECT_EQ(cv::imdecode(bytes, cv::IMREAD_GRAYSCALE).size(), cv::Size(1100, 850));
}

TEST(Draw, GivesTheSameBytesAgain) {
  const Board board = board_from_word("charuco:8x8:20mm:15mm:DICT_4X4_100");
  for (const DrawingFormat format : {DrawingFormat::kPdf, DrawingFormat::kSvg, DrawingFormat::kPng}) {
    EXPECT_TRUE(draw(board, format).bytes == draw(board, format).bytes);
  }
  EXPECT_EQ(draw(board, DrawingFormat::kPdf).bytes.find("CreationDate"), std::string::npos);
}

TEST(Draw, TakesTheSmallestPaperThatHoldsTheBoard) {
  const auto paper = [](const char* word) { return draw(board_from_word(word), DrawingFormat::kPdf).paper; };
  EXPECT_EQ(paper("chessboard:9x6:25mm"), "A4");
  EXPECT_EQ(paper("chessboard:9x6:35mm"), "A3");
  EXPECT_EQ(paper("aprilgrid:6x6:88mm:0.3"), "A0");
  EXPECT_EQ(paper("chessboard:9x6:300mm"), "fit");
}

TEST(Draw, NamesTheBiggestBoardThatFits) {
  DrawOptions options;
  options.paper = "A4";
  for (const char* word : {"chessboard:9x6:30mm", "charuco:8x8:40mm:30mm:DICT_4X4_100", "aprilgrid:6x6:88mm:0.3",
                           "circles:7x7:50mm", "asymmetric_circles:4x11:40mm:row_step=50mm"}) {
    const std::string message = message_of(board_from_word(word), options);
    std::smatch parts;
    ASSERT_TRUE(std::regex_search(message, parts, std::regex("the biggest .* that does is ([0-9.]+) mm: ([^;]*);")))
        << message;
    EXPECT_EQ(draw(board_from_word(parts[2].str()), DrawingFormat::kPdf, options).paper, "A4") << message;
  }
  EXPECT_THAT(message_of(board_from_word("chessboard:200x400:1mm"), options),
              HasSubstr("the biggest square that does is 0."));
  EXPECT_THAT(message_of(board_from_word("chessboard:20x4900:1mm"), options), HasSubstr("nor does any of its kind"));
}

TEST(Draw, RefusesWhatCannotBeDrawn) {
  DrawOptions options;
  options.paper = "A9";
  EXPECT_THAT(message_of(board_from_word("chessboard:9x6:25mm"), options), HasSubstr("there is no paper \"A9\""));
  PointSet points;
  points.file = "points.csv";
  for (int id = 0; id < 4; ++id) points.points.push_back({id, Eigen::Vector3d(id % 2, id / 2, 0)});
  EXPECT_THAT(message_of(points, {}), HasSubstr("no print"));
  options = {};
  options.dpi = 1e7;
  EXPECT_THROW(draw(board_from_word("chessboard:9x6:25mm"), DrawingFormat::kPng, options), Error);
  EXPECT_THROW(format_of_path("board.jpeg"), Error);
  EXPECT_EQ(format_of_path("some.folder/board.pdf"), DrawingFormat::kPdf);
}

}  // namespace
}  // namespace raybundle
