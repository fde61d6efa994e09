// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "grey_png.hpp"

#include <libdeflate.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "big_endian.hpp"
#include "png_filters.hpp"

namespace raybundle::apps {
namespace {

constexpr std::size_t kSignature = 8, kHeader = 13;  // [bytes]
constexpr std::uint32_t kLargest_px = 1u << 15;

struct Release {
  void operator()(libdeflate_decompressor* inflater) const { libdeflate_free_decompressor(inflater); }
};

struct Chunk {
  std::string_view type, data;
  // What makes up an image is marked by a capital letter; the rest are comments.
  bool is_critical() const { return (type[0] & 0x20) == 0; }
};

// Takes the next chunk off `rest`; nothing where a critical one is damaged.
std::optional<Chunk> next_chunk(std::string_view& rest) {
  constexpr std::size_t kAround = 12;  // [bytes]: length, type, checksum
  if (rest.size() < kAround) return std::nullopt;
  const std::size_t length = big_endian(rest, 0, 4);
  if (rest.size() - kAround < length) return std::nullopt;
  const Chunk chunk{rest.substr(4, 4), rest.substr(8, length)};
  const bool sound =
      !chunk.is_critical() || libdeflate_crc32(0, chunk.type.data(), 4 + length) == big_endian(rest, 8 + length, 4);
  rest.remove_prefix(kAround + length);
  return sound ? std::optional(chunk) : std::nullopt;
}

// 8 bits, grey, deflated, with the five filters, not interlaced.
bool is_plain(std::string_view header) { return header.substr(8) == std::string_view("\x08\0\0\0\0", 5); }

// The compressed rows; empty where a critical chunk other than IDAT comes before their end.
std::string compressed_rows(std::string_view rest) {
  std::string rows;
  rows.reserve(rest.size());
  while (const auto chunk = next_chunk(rest)) {
    if (chunk->type == "IDAT") {
      rows += chunk->data;
    } else if (!rows.empty()) {
      return rows;
    } else if (chunk->is_critical()) {
      return {};
    }
  }
  return {};
}

}  // namespace

cv::Mat grey_of_plain_png(std::string_view bytes) {
  std::string_view rest = bytes.substr(kSignature);
  const auto header = next_chunk(rest);
  if (!header || header->type != "IHDR" || header->data.size() != kHeader || !is_plain(header->data)) return {};
  const std::uint32_t width = big_endian(header->data, 0, 4), height = big_endian(header->data, 4, 4);
  if (width == 0 || height == 0 || width > kLargest_px || height > kLargest_px) return {};
  const std::string compressed = compressed_rows(rest);
  const std::size_t size = static_cast<std::size_t>(height) * (1 + width);
  if (size / 1100 > compressed.size()) return {};  // more than deflate can hold: no memory is spent on a promise
  const std::unique_ptr<libdeflate_decompressor, Release> inflater(libdeflate_alloc_decompressor());
  const auto rows = std::make_unique_for_overwrite<std::uint8_t[]>(size);
  if (inflater == nullptr || libdeflate_zlib_decompress(inflater.get(), compressed.data(), compressed.size(),
                                                        rows.get(), size, nullptr) != LIBDEFLATE_SUCCESS) {
    return {};
  }
  cv::Mat image(static_cast<int>(height), static_cast<int>(width), CV_8U);
  return undo_png_filters(rows.get(), image) ? image : cv::Mat();
}

bool is_sound_png(std::string_view bytes) {
  std::string_view rest = bytes.substr(kSignature);
  while (const auto chunk = next_chunk(rest)) {
    if (chunk->type == "IEND") return true;
  }
  return false;
}

}  // namespace raybundle::apps
