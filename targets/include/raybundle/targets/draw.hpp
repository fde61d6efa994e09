// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "raybundle/targets/board.hpp"

namespace raybundle {

enum class DrawingFormat {
  kPdf,  ///< true scale, 1 pt = 1/72 inch
  kSvg,  ///< true scale, in mm
  kPng,  ///< 8-bit grey, for screens
};

struct DrawOptions {
  std::string paper;        ///< one of paper_names(); empty: the smallest of A4 to A0 that holds the board, else fit
  double margin_m = 0.010;  ///< white on each side: printers cannot reach the edge, detectors need it
  int square_px = 60;       ///< of a PNG: pixels of a square, tag or step; used when dpi is 0
  double dpi = 0.0;         ///< of a PNG: pixels per inch, true scale with ruler and caption
};

/// A drawn board.
struct Drawing {
  std::string bytes;     ///< the file
  std::string paper;     ///< A4, ..., or fit; empty for a PNG that has no scale
  double width_m = 0.0;  ///< of the page, or of the whole image at the board's own scale
  double height_m = 0.0;
};

/// A4, A3, A2, A1, A0, letter, legal, tabloid and fit (the page is as large as the board needs).
std::vector<std::string> paper_names();

/// The format that a file's name ends in. Throws Error(kBadInput) when it is none of .pdf, .svg, .png.
DrawingFormat format_of_path(const std::string& path);

/// Draws a board at true scale, with a 100 mm ruler and the word that names it below. The page is turned when the
/// board fits only so. Same board and options: same bytes.
///
/// @throws Error(kBadInput) when the board does not fit the paper: names the largest board of its kind that does
Drawing draw(const Board& board, DrawingFormat format, const DrawOptions& options = {});

}  // namespace raybundle
