// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/stereo/remap.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace raybundle {
namespace {

constexpr double kRounding_px = 1e-6;  // of a ray that goes to the middle of an outermost pixel

using RemapRow = void (*)(const RemapTable& table, GreyView image, int row, Extent columns, std::uint8_t* out);

// Columns of a row: the four neighbours, weighted by the eight bits behind the point.
void remap_row_scalar(const RemapTable& table, GreyView image, int row, Extent columns, std::uint8_t* out) {
  const std::size_t first = static_cast<std::size_t>(row) * table.size.width;
  for (int u = columns.begin; u < columns.end; ++u) {
    const std::int32_t x = table.x_256[first + u];
    const std::int32_t y = table.y_256[first + u];
    const std::uint8_t* top = image.row(y >> 8) + (x >> 8);
    const std::uint8_t* bottom = image.row((y >> 8) + 1) + (x >> 8);
    const int right_weight = x & 255;
    const int bottom_weight = y & 255;
    const int above = top[0] * (256 - right_weight) + top[1] * right_weight;
    const int below = bottom[0] * (256 - right_weight) + bottom[1] * right_weight;
    const int value = (above * (256 - bottom_weight) + below * bottom_weight + (1 << 15)) >> 16;
    out[u] = static_cast<std::uint8_t>(table.covered[first + u] ? value : 0);
  }
}

#if defined(__x86_64__)
// Both neighbours of a row with one gather of four bytes. The last bytes of the image are reached by reading earlier
// and shifting, so that nothing behind the image is touched.
[[gnu::target("avx2")]] inline __m256i two_neighbours(const std::uint8_t* pixels, __m256i offset, __m256i last) {
  const __m256i base = _mm256_min_epi32(offset, last);
  const __m256i four = _mm256_i32gather_epi32(reinterpret_cast<const int*>(pixels), base, 1);
  return _mm256_srlv_epi32(four, _mm256_slli_epi32(_mm256_sub_epi32(offset, base), 3));
}

[[gnu::target("avx2")]] inline __m256i between(__m256i neighbours, __m256i right_weight) {
  const __m256i left = _mm256_and_si256(neighbours, _mm256_set1_epi32(255));
  const __m256i right = _mm256_and_si256(_mm256_srli_epi32(neighbours, 8), _mm256_set1_epi32(255));
  // left · 256 + (right - left) · weight; both factors fit into 16 bits
  const __m256i step = _mm256_mullo_epi16(_mm256_sub_epi16(right, left), right_weight);
  return _mm256_and_si256(_mm256_add_epi16(_mm256_slli_epi32(left, 8), step), _mm256_set1_epi32(0xffff));
}

[[gnu::target("avx2")]] void remap_row_avx2(const RemapTable& table, GreyView image, int row, Extent columns,
                                            std::uint8_t* out) {
  const std::size_t first = static_cast<std::size_t>(row) * table.size.width;
  const __m256i fraction = _mm256_set1_epi32(255);
  const __m256i stride = _mm256_set1_epi32(static_cast<int>(image.stride));
  const __m256i last = _mm256_set1_epi32(static_cast<int>((image.height - 1) * image.stride + image.width - 4));
  int u = columns.begin;
  for (; u + 8 <= columns.end; u += 8) {
    const __m256i x = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(&table.x_256[first + u]));
    const __m256i y = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(&table.y_256[first + u]));
    const __m256i offset =
        _mm256_add_epi32(_mm256_mullo_epi32(_mm256_srli_epi32(y, 8), stride), _mm256_srli_epi32(x, 8));
    const __m256i right_weight = _mm256_and_si256(x, fraction);
    const __m256i above = between(two_neighbours(image.pixels, offset, last), right_weight);
    const __m256i below = between(two_neighbours(image.pixels, _mm256_add_epi32(offset, stride), last), right_weight);
    const __m256i step = _mm256_mullo_epi32(_mm256_sub_epi32(below, above), _mm256_and_si256(y, fraction));
    const __m256i value = _mm256_srli_epi32(
        _mm256_add_epi32(_mm256_add_epi32(_mm256_slli_epi32(above, 8), step), _mm256_set1_epi32(1 << 15)), 16);
    const __m128i words = _mm_packus_epi32(_mm256_castsi256_si128(value), _mm256_extracti128_si256(value, 1));
    const __m128i bytes = _mm_packus_epi16(words, words);
    const __m128i covered = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&table.covered[first + u]));
    const __m128i kept = _mm_and_si128(bytes, _mm_sub_epi8(_mm_setzero_si128(), covered));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + u), kept);
  }
  remap_row_scalar(table, image, row, {u, columns.end}, out);
}
#endif

RemapRow row_function(Simd simd) {
#if defined(__x86_64__)
  if (simd != Simd::kNone) return remap_row_avx2;
#else
  static_cast<void>(simd);
#endif
  return remap_row_scalar;
}

}  // namespace

RemapTable remap_table(const Camera& camera, const RectifiedCamera& rectified,
                       const Eigen::Quaterniond& rectified_from_camera) {
  const std::size_t count = static_cast<std::size_t>(rectified.size.width) * rectified.size.height;
  RemapTable table{camera.size, rectified.size, std::vector<std::int32_t>(count), std::vector<std::int32_t>(count),
                   std::vector<std::uint8_t>(count)};
  const Eigen::Matrix3d camera_from_rectified = rectified_from_camera.conjugate().toRotationMatrix();
  std::size_t i = 0;
  for (int v = 0; v < rectified.size.height; ++v) {
    for (int u = 0; u < rectified.size.width; ++u, ++i) {
      const auto ray = rectified.ray_from_pixel({u, v});
      if (!ray) continue;
      const auto pixel = pixel_from_ray(camera, camera_from_rectified * *ray);
      if (!pixel || !(pixel->minCoeff() >= -kRounding_px) || !(pixel->x() <= camera.size.width - 1 + kRounding_px) ||
          !(pixel->y() <= camera.size.height - 1 + kRounding_px)) {
        continue;
      }
      // On the last row and column the neighbour behind is taken with 255/256 of the weight.
      const auto rounded = [](double x, int pixels) {
        return std::clamp(static_cast<int>(std::lround(256 * x)), 0, 256 * (pixels - 1) - 1);
      };
      table.x_256[i] = rounded(pixel->x(), camera.size.width);
      table.y_256[i] = rounded(pixel->y(), camera.size.height);
      table.covered[i] = 1;
    }
  }
  return table;
}

void remap(const RemapTable& table, GreyView image, ImageView<std::uint8_t> out, Simd simd) {
  assert(image.width == table.source.width && image.height == table.source.height);
  assert(out.width == table.size.width && out.height == table.size.height);
  const RemapRow row = row_function(simd);
  for (int v = 0; v < out.height; ++v) {
    const Extent columns = table.extent(v);
    columns.fill_beyond(out.row(v), out.width, std::uint8_t{0});
    row(table, image, v, columns, out.row(v));
  }
}

}  // namespace raybundle
