// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/targets/draw.hpp"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <string_view>
#include <utility>

#include "draw_page.hpp"
#include "raybundle/geometry/error.hpp"
#include "raybundle/targets/board_kind.hpp"

namespace raybundle {
namespace {

constexpr double kPointsPerMetre = 72.0 / 0.0254;

struct Release {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, Release>;
using Context = std::unique_ptr<cairo_t, Release>;

void require_success(cairo_status_t status) {
  if (status == CAIRO_STATUS_SUCCESS) return;
  throw Error(ErrorKind::kIo, std::string("the board cannot be drawn: ") + cairo_status_to_string(status));
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void set_gray(cairo_t* context, double gray) { cairo_set_source_rgb(context, gray, gray, gray); }

// All is one path: filled one by one, shapes that touch would show a hairline between them. Shapes do not overlap, so
// that on an inverted board the even-odd rule cuts them out of the ground.
void paint_picture(cairo_t* context, const BoardPicture& picture) {
  set_gray(context, 0.0);
  cairo_set_fill_rule(context, CAIRO_FILL_RULE_EVEN_ODD);
  if (picture.inverted) cairo_rectangle(context, 0.0, 0.0, picture.size.x(), picture.size.y());
  for (const PictureRectangle& shape : picture.rectangles) {
    cairo_rectangle(context, shape.corner.x(), shape.corner.y(), shape.size.x(), shape.size.y());
  }
  for (const PictureDisc& disc : picture.discs) {
    cairo_new_sub_path(context);
    cairo_arc(context, disc.centre.x(), disc.centre.y(), disc.radius, 0.0, 2.0 * std::numbers::pi);
    cairo_close_path(context);
  }
  cairo_fill(context);
}

// Text with its baseline's left end at (x, y), made smaller when it is wider than allowed.
void paint_text(cairo_t* context, const std::string& text, double x, double y, double widest) {
  // The font built into cairo: it looks the same on every machine, fonts installed or not.
  cairo_select_font_face(context, "@cairo:monospace", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  constexpr double kSizeOverCapital = 1.4;
  double size = kTextHeight * kSizeOverCapital;
  cairo_set_font_size(context, size);
  cairo_text_extents_t extents;
  cairo_text_extents(context, text.c_str(), &extents);
  if (extents.x_advance > widest) cairo_set_font_size(context, size * widest / extents.x_advance);
  cairo_move_to(context, x, y);
  cairo_show_text(context, text.c_str());
}

// A line of exactly 100 mm between the outer edges of its first and last tick, with a tick every 5 mm.
void paint_ruler(cairo_t* context, const Eigen::Vector2d& corner) {
  constexpr double kLine = 0.0002;
  const double bottom = corner.y() + kRulerHeight;
  for (int tick = 0; tick <= 20; ++tick) {
    const double height = tick % 20 == 0 ? kRulerHeight : tick % 2 == 0 ? 0.6 * kRulerHeight : 0.35 * kRulerHeight;
    const double x = corner.x() + (kRulerLength - kLine) * tick / 20.0;
    cairo_rectangle(context, x, bottom - height, kLine, height);
  }
  cairo_rectangle(context, corner.x(), bottom - kLine, kRulerLength, kLine);
  cairo_fill(context);
}

void paint_page(cairo_t* context, const Page& page, const BoardPicture& picture, const std::string& word) {
  set_gray(context, 1.0);
  cairo_paint(context);
  cairo_save(context);
  cairo_translate(context, page.board.x(), page.board.y());
  paint_picture(context, picture);
  cairo_restore(context);
  if (!page.strip) return;
  set_gray(context, 0.0);
  paint_ruler(context, *page.strip);
  const double baseline = page.strip->y() + kRulerHeight + 1.8 * kTextHeight;
  const double widest = page.size.x() - 2 * page.strip->x();
  paint_text(context, word + "   ruler: 100 mm, print at 100 %", page.strip->x(), baseline,
             std::max(widest, kRulerLength));
}

// Draws a page in metres on a surface of `units_per_metre`, and finishes it.
void paint_on(Surface surface, double units_per_metre, const Page& page, const BoardPicture& picture,
              const std::string& word) {
  require_success(cairo_surface_status(surface.get()));
  const Context context(cairo_create(surface.get()));
  cairo_set_antialias(context.get(), CAIRO_ANTIALIAS_BEST);
  cairo_scale(context.get(), units_per_metre, units_per_metre);
  paint_page(context.get(), page, picture, word);
  require_success(cairo_status(context.get()));
  cairo_surface_finish(surface.get());
  require_success(cairo_surface_status(surface.get()));
}

std::string pdf_of(const Page& page, const BoardPicture& picture, const std::string& word) {
  std::string bytes;
  Surface surface(cairo_pdf_surface_create_for_stream(append, &bytes, page.size.x() * kPointsPerMetre,
                                                      page.size.y() * kPointsPerMetre));
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, word.c_str());
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE, "");  // same board, same bytes
  paint_on(std::move(surface), kPointsPerMetre, page, picture, word);
  return bytes;
}

std::string svg_of(const Page& page, const BoardPicture& picture, const std::string& word) {
  constexpr double kMillimetresPerMetre = 1000.0;
  std::string bytes;
  Surface surface(cairo_svg_surface_create_for_stream(append, &bytes, page.size.x() * kMillimetresPerMetre,
                                                      page.size.y() * kMillimetresPerMetre));
  cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_MM);
  paint_on(std::move(surface), kMillimetresPerMetre, page, picture, word);
  // cairo numbers the surfaces of a process; nothing refers to the number, and without it the bytes stay the same.
  constexpr std::string_view kNumbered = "id=\"surface";
  const size_t at = bytes.find(kNumbered);
  if (at != std::string::npos) {
    const size_t number = at + kNumbered.size();
    bytes.erase(number, bytes.find('"', number) - number);
  }
  return bytes;
}

std::string png_of(const Page& page, const BoardPicture& picture, const std::string& word, double px_per_metre) {
  constexpr int kLargestSide = 20'000;
  const int width = static_cast<int>(std::lround(std::min(page.size.x() * px_per_metre, 1e9)));
  const int height = static_cast<int>(std::lround(std::min(page.size.y() * px_per_metre, 1e9)));
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide) {
    throw Error(ErrorKind::kBadInput,
                fmt::format("the image would have {} x {} pixels (at most {} a side); change --dpi or --square-px",
                            width, height, kLargestSide));
  }
  cv::Mat image(height, width, CV_8UC4);
  paint_on(Surface(cairo_image_surface_create_for_data(image.data, CAIRO_FORMAT_RGB24, width, height,
                                                       static_cast<int>(image.step))),
           px_per_metre, page, picture, word);
  cv::Mat gray(height, cairo_format_stride_for_width(CAIRO_FORMAT_A8, width), CV_8U);
  cv::extractChannel(image, gray.colRange(0, width), 0);
  std::string bytes;
  const Surface as_alpha(  // which cairo writes as grey
      cairo_image_surface_create_for_data(gray.data, CAIRO_FORMAT_A8, width, height, gray.cols));
  require_success(cairo_surface_write_to_png_stream(as_alpha.get(), append, &bytes));
  return bytes;
}

// The first length of a kind: the square, the tag or the step that --square-px means.
double module_of(const Board& board) {
  for (const BoardField& field : board_kind_of(board).fields) {
    if (field.form == FieldForm::kLength) return std::get<double>(field.get(board));
  }
  return 0.0;
}

}  // namespace

DrawingFormat format_of_path(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".pdf") return DrawingFormat::kPdf;
  if (extension == ".svg") return DrawingFormat::kSvg;
  if (extension == ".png") return DrawingFormat::kPng;
  throw Error(ErrorKind::kBadInput,
              fmt::format("a board is drawn as .pdf or .svg (to print) or .png (for a screen), not as \"{}\"", path));
}

Drawing draw(const Board& board, DrawingFormat format, const DrawOptions& options) {
  if (!(options.margin_m >= 0.0) || !(options.margin_m < 10.0)) {
    throw Error(ErrorKind::kBadInput, fmt::format("a margin of {} m is no margin of a page", options.margin_m));
  }
  const BoardPicture picture = picture_of(board);
  const std::string word = word_of(board);
  if (format == DrawingFormat::kPng && options.dpi == 0.0) {
    // One square of margin, so that the board's edges lie between pixels.
    const double module_m = module_of(board);
    const Page page = bare_page_of(picture, module_m);
    return {png_of(page, picture, word, options.square_px / module_m), "", page.size.x(), page.size.y()};
  }
  const Page page = page_of(board, picture, options);
  Drawing drawing{"", page.paper, page.size.x(), page.size.y()};
  switch (format) {
    case DrawingFormat::kPdf:
      drawing.bytes = pdf_of(page, picture, word);
      break;
    case DrawingFormat::kSvg:
      drawing.bytes = svg_of(page, picture, word);
      break;
    case DrawingFormat::kPng:
      drawing.bytes = png_of(page, picture, word, options.dpi / 0.0254);
      break;
  }
  return drawing;
}

}  // namespace raybundle
