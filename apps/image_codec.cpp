// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "image_codec.hpp"

#include <png.h>
#include <turbojpeg.h>

#include <cassert>
#include <csetjmp>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

#include "big_endian.hpp"
#include "grey_png.hpp"
#include "media/media.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::apps {
namespace {

constexpr std::uint64_t kMostPixels = 1u << 30;  // as OpenCV, which says what is wrong with larger ones

struct Release {
  void operator()(void* turbojpeg) const { tjDestroy(turbojpeg); }
  void operator()(unsigned char* of_turbojpeg) const { tjFree(of_turbojpeg); }
};
using Turbojpeg = std::unique_ptr<void, Release>;

bool few_pixels(std::uint64_t width, std::uint64_t height) { return width * height <= kMostPixels; }

// Empty where turbojpeg has any doubt.
cv::Mat grey_of_jpeg(const std::string& bytes) {
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  const Turbojpeg decoder(tjInitDecompress());
  int width = 0, height = 0, subsampling = 0, colours = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colours) != 0) return {};
  if (colours == TJCS_CMYK || colours == TJCS_YCCK || !few_pixels(width, height)) return {};
  cv::Mat image(height, width, CV_8U);
  const int pitch = static_cast<int>(image.step);
  const bool decoded =
      tjDecompress2(decoder.get(), data, bytes.size(), image.data, width, pitch, height, TJPF_GRAY, 0) == 0;
  return decoded ? image : cv::Mat();
}

// libpng jumps out of its functions at an error: back to the caller of setjmp(), in whose frame nothing may be left to
// destroy.
[[noreturn]] void leave(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void be_quiet(png_structp, png_const_charp) {}

void take_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto& rest = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (rest.size() < count) png_error(png, "the file ends early");
  rest.copy(reinterpret_cast<char*>(to), count);
  rest.remove_prefix(count);
}

// No exception may pass through libpng.
bool append(std::string& bytes, png_const_bytep from, std::size_t count) try {
  bytes.append(reinterpret_cast<const char*>(from), count);
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

void append_bytes(png_structp png, png_bytep from, std::size_t count) {
  auto& bytes = *static_cast<std::string*>(png_get_io_ptr(png));
  if (!append(bytes, from, count)) png_error(png, "no memory is left");
}

struct PngReader {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, be_quiet);
  png_infop info = png_create_info_struct(png);

  PngReader() {
    if (info == nullptr) throw std::bad_alloc();
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

struct PngWriter {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, be_quiet);
  png_infop info = png_create_info_struct(png);

  PngWriter() {
    if (info == nullptr) throw std::bad_alloc();
  }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;
  ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

bool read_header(const PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_info(reader.png, reader.info);
  return true;
}

bool read_rows(const PngReader& reader, png_bytepp rows) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_set_swap(reader.png);  // of 16 bits; the file has the high byte first
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  png_read_image(reader.png, rows);
  return true;
}

bool write_rows(const PngWriter& writer, const cv::Mat& image, png_bytepp rows) {
  constexpr int kFast = 1;  // zlib's levels: smaller by a tenth takes several times as long
  if (setjmp(png_jmpbuf(writer.png)) != 0) return false;
  png_set_compression_level(writer.png, kFast);
  png_set_filter(writer.png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(image.cols), static_cast<png_uint_32>(image.rows),
               image.depth() == CV_16U ? 16 : 8, image.channels() == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(writer.png, writer.info);
  png_set_swap(writer.png);
  png_set_bgr(writer.png);
  png_write_image(writer.png, rows);
  png_write_end(writer.png, nullptr);
  return true;
}

std::vector<png_bytep> rows_of(const cv::Mat& image) {
  std::vector<png_bytep> rows;
  for (int y = 0; y < image.rows; ++y) rows.push_back(const_cast<png_bytep>(image.ptr(y)));
  return rows;
}

// Empty for other than grey values of 8 or 16 bits, and where libpng stops.
cv::Mat grey_of_png(const std::string& bytes) {
  const PngReader reader;
  std::string_view rest = bytes;
  png_set_read_fn(reader.png, &rest, take_bytes);
  if (!read_header(reader)) return {};
  const png_uint_32 width = png_get_image_width(reader.png, reader.info),
                    height = png_get_image_height(reader.png, reader.info);
  const int bits = png_get_bit_depth(reader.png, reader.info);
  if (png_get_color_type(reader.png, reader.info) != PNG_COLOR_TYPE_GRAY || bits < 8) return {};
  if (!few_pixels(width, height)) return {};
  cv::Mat image(static_cast<int>(height), static_cast<int>(width), bits == 8 ? CV_8U : CV_16U);
  return read_rows(reader, rows_of(image).data()) ? image : cv::Mat();
}

// Behind the segments that say what the image is like; one of them may hold a thumbnail, which has an end of its own.
// Source: ITU-T T.81, annex B.
bool jpeg_has_end(std::string_view bytes) {
  constexpr std::uint8_t kStartOfScan = 0xDA;
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && static_cast<std::uint8_t>(bytes[at + 1]) != kStartOfScan) {
    at += 2 + big_endian(bytes, at + 2, 2);
  }
  return at < bytes.size() && bytes.find("\xff\xd9", at) != std::string_view::npos;
}

// Some programs append bytes of their own behind the last chunk.
bool png_has_end(std::string_view bytes) {
  constexpr std::size_t kSignature = 8, kAround = 12;  // [bytes]: of a chunk its length, type and checksum
  for (std::size_t at = kSignature; at + kAround <= bytes.size(); at += kAround + big_endian(bytes, at, 4)) {
    if (bytes.substr(at + 4, 4) == "IEND") return true;
  }
  return false;
}

}  // namespace

bool is_jpeg(std::string_view bytes) { return bytes.starts_with("\xff\xd8\xff"); }

bool is_png(std::string_view bytes) { return bytes.starts_with("\x89PNG\r\n\x1a\n"); }

bool is_dicom(std::string_view bytes) {
  constexpr std::size_t kPreamble = 128;  // [bytes], DICOM PS3.10, section 7.1
  return bytes.size() > kPreamble && bytes.substr(kPreamble).starts_with("DICM");
}

bool is_cut_off(std::string_view bytes) {
  return (is_jpeg(bytes) && !jpeg_has_end(bytes)) || (is_png(bytes) && !png_has_end(bytes));
}

cv::Mat decoded_grey(const std::string& bytes) {
  cv::Mat image;
  if (is_jpeg(bytes)) image = grey_of_jpeg(bytes);
  if (is_png(bytes)) {
    image = grey_of_plain_png(bytes);
    if (image.empty()) image = grey_of_png(bytes);
  }
  if (!image.empty()) return image;
  if (is_png(bytes) && !is_sound_png(bytes)) return {};  // of which OpenCV's libpng would tell the user, in its words
  if (is_dicom(bytes)) throw Error(ErrorKind::kIo, "an image in DICOM, which is not read: convert it to PNG");
  try {
    return media().decode_grey(bytes);
  } catch (const Error& missing) {
    if (!is_jpeg(bytes) && !is_png(bytes)) throw;
    throw Error(ErrorKind::kIo, std::string("damaged, or of a kind that is rare: ") + missing.what());
  }
}

std::string png_from(const cv::Mat& image) {
  assert(image.type() == CV_8UC1 || image.type() == CV_16UC1 || image.type() == CV_8UC3);
  std::string bytes;
  const PngWriter writer;
  png_set_write_fn(writer.png, &bytes, append_bytes, nullptr);
  if (!write_rows(writer, image, rows_of(image).data())) {
    throw Error(ErrorKind::kIo, "an image cannot be made a PNG");
  }
  return bytes;
}

std::string jpeg_from(const cv::Mat& image, int quality) {
  assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  const bool grey = image.channels() == 1;
  const Turbojpeg encoder(tjInitCompress());
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int error = tjCompress2(encoder.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                                grey ? TJPF_GRAY : TJPF_BGR, &bytes, &size, grey ? TJSAMP_GRAY : TJSAMP_420, quality,
                                TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, Release> owned(bytes);
  if (error != 0)
    throw Error(ErrorKind::kIo, std::string("an image cannot be made a JPEG: ") + tjGetErrorStr2(encoder.get()));
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace raybundle::apps
