// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <libdeflate.h>

#include <opencv2/core.hpp>
#include <string>

#include "fuzz_reader.hpp"
#include "grey_png.hpp"
#include "image_codec.hpp"
#include "media/media.hpp"

namespace {

using namespace raybundle;

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
constexpr std::uint8_t kFilters = 5;

std::string big_endian(std::size_t number) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift & 0xff);
  return bytes;
}

std::string checksum_of(std::string_view type_and_data) {
  return big_endian(libdeflate_crc32(0, type_and_data.data(), type_and_data.size()));
}

// Checksums are put right: a fuzzer does not guess them, and would hardly ever get beyond them.
std::string with_right_checksums(std::string png) {
  for (std::size_t at = kSignature.size(); png.size() - at >= 12;) {
    std::size_t length = 0;
    for (std::size_t i = at; i < at + 4; ++i) length = length << 8 | static_cast<std::uint8_t>(png[i]);
    if (png.size() - at - 12 < length) break;
    png.replace(at + 8 + length, 4, checksum_of(std::string_view(png).substr(at + 4, 4 + length)));
    at += 12 + length;
  }
  return png;
}

std::string chunk(const std::string& type, const std::string& data) {
  return big_endian(data.size()) + type + data + checksum_of(type + data);
}

std::string deflated(const std::string& bytes) {
  libdeflate_compressor* const deflater = libdeflate_alloc_compressor(1);
  std::string small(libdeflate_zlib_compress_bound(deflater, bytes.size()), '\0');
  small.resize(libdeflate_zlib_compress(deflater, bytes.data(), bytes.size(), small.data(), small.size()));
  libdeflate_free_compressor(deflater);
  return small;
}

struct Rows {
  std::size_t width = 0, height = 0;
  std::string filtered;
  bool known_filters = true;
};

// The first byte is the width, then come rows, each with its filter: one of six, of which the last does not exist.
Rows rows_from(std::string_view bytes) {
  Rows rows;
  rows.width = 1 + static_cast<std::uint8_t>(bytes[0]) % 40;
  rows.height = (bytes.size() - 1) / (1 + rows.width);
  rows.filtered = bytes.substr(1, rows.height * (1 + rows.width));
  for (std::size_t at = 0; at < rows.filtered.size(); at += 1 + rows.width) {
    const int filter = static_cast<std::uint8_t>(rows.filtered[at]) % (kFilters + 1);
    rows.filtered[at] = static_cast<char>(filter);
    if (filter == kFilters) rows.known_filters = false;
  }
  return rows;
}

std::string png_of(const Rows& rows) {
  const std::string header = big_endian(rows.width) + big_endian(rows.height) + std::string("\x08\0\0\0\0", 5);
  return std::string(kSignature) + chunk("IHDR", header) + chunk("IDAT", deflated(rows.filtered)) + chunk("IEND", "");
}

// @return  whether there is an image, which is the one that libpng reads where that takes the file
bool read(const std::string& png) {
  const cv::Mat image = apps::grey_of_plain_png(png);
  if (image.empty()) return false;
  fuzz::require(image.type() == CV_8U, "8 bits");
  const cv::Mat expected = apps::media().decode_grey(png);
  if (expected.empty()) return true;
  fuzz::require(image.size() == expected.size(), "the size that libpng finds");
  fuzz::require(cv::norm(image, expected, cv::NORM_INF) == 0.0, "the grey values that libpng reads");
  return true;
}

}  // namespace

// A PNG is read as it is and with its checksums put right. Of other bytes a PNG is made.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz::only_errors(data, size, [](std::string_view bytes) {
    if (apps::is_png(bytes)) {
      read(std::string(bytes));
      read(with_right_checksums(std::string(bytes)));
    } else if (!bytes.empty()) {
      const Rows rows = rows_from(bytes);
      const bool sound = rows.height > 0 && rows.known_filters;
      fuzz::require(read(png_of(rows)) == sound, "an image of sound rows");
    }
  });
}
