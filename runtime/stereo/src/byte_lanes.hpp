// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#if defined(__AVX2__)
#include <immintrin.h>
#endif

// 32 bytes that are worked on together, in plain C++ and with AVX2: the same operations, the same bits.

namespace raybundle {

inline constexpr int kLanes = 32;

/// What each count of bits costs, for the nibbles 0..15.
using NibbleCosts = std::array<std::uint8_t, 16>;

struct PlainBytes {
  static constexpr int kCount = kLanes;
  std::array<std::uint8_t, kLanes> lane;

  static PlainBytes load(const std::uint8_t* from) {
    PlainBytes bytes;
    std::copy_n(from, kLanes, bytes.lane.begin());
    return bytes;
  }
  static PlainBytes all(std::uint8_t value) {
    PlainBytes bytes;
    bytes.lane.fill(value);
    return bytes;
  }
  /// Four equal bytes, again and again.
  static PlainBytes repeated(std::uint32_t four) { return all(static_cast<std::uint8_t>(four)); }
  void store(std::uint8_t* to) const { std::copy_n(lane.begin(), kLanes, to); }

  template <typename Operation>
  static PlainBytes each(PlainBytes a, PlainBytes b, Operation operation) {
    for (std::size_t i = 0; i < kLanes; ++i) a.lane[i] = static_cast<std::uint8_t>(operation(a.lane[i], b.lane[i]));
    return a;
  }
  friend PlainBytes add(PlainBytes a, PlainBytes b) {  // stays at 255
    return each(a, b, [](int x, int y) { return std::min(x + y, 255); });
  }
  friend PlainBytes subtract(PlainBytes a, PlainBytes b) {
    return each(a, b, [](int x, int y) { return x - y; });
  }
  friend PlainBytes least(PlainBytes a, PlainBytes b) {
    return each(a, b, [](int x, int y) { return std::min(x, y); });
  }
  friend PlainBytes most(PlainBytes a, PlainBytes b) {
    return each(a, b, [](int x, int y) { return std::max(x, y); });
  }
  friend PlainBytes quarter(PlainBytes a) {  // rounded down
    return each(a, a, [](int x, int) { return x / 4; });
  }
  friend PlainBytes operator|(PlainBytes a, PlainBytes b) {
    return each(a, b, [](int x, int y) { return x | y; });
  }
  friend PlainBytes operator&(PlainBytes a, PlainBytes b) {
    return each(a, b, [](int x, int y) { return x & y; });
  }
  friend PlainBytes at_least(PlainBytes a, PlainBytes b) {  // 255 where a >= b
    return each(a, b, [](int x, int y) { return x >= y ? 255 : 0; });
  }
  /// The cost of the bits in which two nibbles differ.
  static PlainBytes difference(PlainBytes a, PlainBytes b, const NibbleCosts& costs) {
    return each(a, b, [&](int x, int y) { return costs[static_cast<std::size_t>((x ^ y) & 15)]; });
  }
  /// Every lane becomes the one before it; the first one becomes the last of `before`.
  static PlainBytes shifted_up(PlainBytes before, PlainBytes a) {
    std::copy_backward(a.lane.begin(), a.lane.end() - 1, a.lane.end());
    a.lane[0] = before.lane[kLanes - 1];
    return a;
  }
  /// Every lane becomes the one behind it; the last one becomes the first of `behind`.
  static PlainBytes shifted_down(PlainBytes a, PlainBytes behind) {
    std::copy(a.lane.begin() + 1, a.lane.end(), a.lane.begin());
    a.lane[kLanes - 1] = behind.lane[0];
    return a;
  }
  /// The least of all lanes, in all lanes.
  PlainBytes spread_least() const { return all(*std::min_element(lane.begin(), lane.end())); }
  std::uint8_t first() const { return lane[0]; }
  /// Bit i is set where lane i of both is the same.
  friend std::uint32_t equal_lanes(PlainBytes a, PlainBytes b) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kLanes; ++i) bits |= static_cast<std::uint32_t>(a.lane[i] == b.lane[i]) << i;
    return bits;
  }
};

#if defined(__AVX2__)
struct Avx2Bytes {
  static constexpr int kCount = kLanes;
  __m256i lane;

  static Avx2Bytes load(const std::uint8_t* from) {
    return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))};
  }
  static Avx2Bytes all(std::uint8_t value) { return {_mm256_set1_epi8(static_cast<char>(value))}; }
  static Avx2Bytes repeated(std::uint32_t four) { return {_mm256_set1_epi32(static_cast<int>(four))}; }
  void store(std::uint8_t* to) const { _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), lane); }

  friend Avx2Bytes add(Avx2Bytes a, Avx2Bytes b) { return {_mm256_adds_epu8(a.lane, b.lane)}; }
  friend Avx2Bytes subtract(Avx2Bytes a, Avx2Bytes b) { return {_mm256_sub_epi8(a.lane, b.lane)}; }
  friend Avx2Bytes least(Avx2Bytes a, Avx2Bytes b) { return {_mm256_min_epu8(a.lane, b.lane)}; }
  friend Avx2Bytes most(Avx2Bytes a, Avx2Bytes b) { return {_mm256_max_epu8(a.lane, b.lane)}; }
  friend Avx2Bytes quarter(Avx2Bytes a) {
    return {_mm256_and_si256(_mm256_srli_epi16(a.lane, 2), _mm256_set1_epi8(63))};
  }
  friend Avx2Bytes operator|(Avx2Bytes a, Avx2Bytes b) { return {_mm256_or_si256(a.lane, b.lane)}; }
  friend Avx2Bytes operator&(Avx2Bytes a, Avx2Bytes b) { return {_mm256_and_si256(a.lane, b.lane)}; }
  friend Avx2Bytes at_least(Avx2Bytes a, Avx2Bytes b) { return {_mm256_cmpeq_epi8(most(a, b).lane, a.lane)}; }
  static Avx2Bytes difference(Avx2Bytes a, Avx2Bytes b, const NibbleCosts& costs) {
    const __m256i table = _mm256_broadcastsi128_si256(_mm_loadu_si128(reinterpret_cast<const __m128i*>(costs.data())));
    return {_mm256_shuffle_epi8(table, _mm256_xor_si256(a.lane, b.lane))};
  }
  static Avx2Bytes shifted_up(Avx2Bytes before, Avx2Bytes a) {
    return {_mm256_alignr_epi8(a.lane, _mm256_permute2x128_si256(before.lane, a.lane, 0x21), 15)};
  }
  static Avx2Bytes shifted_down(Avx2Bytes a, Avx2Bytes behind) {
    return {_mm256_alignr_epi8(_mm256_permute2x128_si256(a.lane, behind.lane, 0x21), a.lane, 1)};
  }
  Avx2Bytes spread_least() const {
    __m128i half = _mm_min_epu8(_mm256_castsi256_si128(lane), _mm256_extracti128_si256(lane, 1));
    half = _mm_minpos_epu16(_mm_min_epu8(half, _mm_srli_epi16(half, 8)));
    return {_mm256_broadcastb_epi8(half)};
  }
  std::uint8_t first() const { return static_cast<std::uint8_t>(_mm256_cvtsi256_si32(lane)); }
  friend std::uint32_t equal_lanes(Avx2Bytes a, Avx2Bytes b) {
    return static_cast<std::uint32_t>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(a.lane, b.lane)));
  }
};
#endif

}  // namespace raybundle
