// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "column.hpp"
#include "row_kernels.hpp"

// Matching costs, for one kind of bytes. What is not bytes is written for the compiler to make vectors of: whole
// numbers, or single operations that round the same way on every machine.

namespace raybundle {
namespace {

template <typename Bytes>
void census_row(const CensusRow& row) {
  for (int x = 0; x < row.width; x += kLanes) {
    const Bytes centre = Bytes::load(row.centre + x);
    for (std::size_t k = 0; k < row.offsets.size(); k += 4) {
      Bytes code = Bytes::all(0);
      for (std::size_t bit = 0; bit < 4 && k + bit < row.offsets.size(); ++bit) {
        const Bytes neighbour = Bytes::load(row.centre + x + row.offsets[k + bit]);
        code = code | (at_least(neighbour, centre) & Bytes::all(static_cast<std::uint8_t>(1 << bit)));
      }
      code.store(row.codes + static_cast<std::ptrdiff_t>(k / 4) * row.plane_stride + x);
    }
  }
}

template <typename Bytes, int n>
void census_cost_row(CensusCostRow row) {
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    const std::ptrdiff_t partner = row.width - 1 - x + row.first[x];
    Column<Bytes, n> costs = Column<Bytes, n>::all(0);
    for (int k = 0; k < row.planes; ++k) {
      const Bytes left = Bytes::all(row.left_codes[k * row.plane_stride + x]);
      const std::uint8_t* right = row.right_codes + k * row.plane_stride + partner;
      for (int j = 0; j < n; ++j) {
        costs.part[j] =
            add(costs.part[j], Bytes::difference(left, Bytes::load(right + j * Bytes::kCount), row.nibble_costs));
      }
    }
    for (int j = 0; j < n; ++j) {
      costs.part[j] = most(costs.part[j], Bytes::load(row.right_limits + partner + j * Bytes::kCount));
    }
    costs.store(row.costs + x * n * Bytes::kCount);
  }
}

template <typename Bytes>
void enter_row(EnterRow<std::uint8_t> row) {
  for (std::ptrdiff_t i = 0; i < row.count; i += Bytes::kCount) {
    const Bytes without = subtract(Bytes::load(row.sums + i), Bytes::load(row.leaves + i));
    add(without, Bytes::load(row.enters + i)).store(row.sums + i);
  }
}

inline void enter_row_wide(const EnterRow<std::uint16_t>& row) {
  for (std::ptrdiff_t i = 0; i < row.count; ++i) {
    row.sums[i] = static_cast<std::uint16_t>(row.sums[i] + row.enters[i] - row.leaves[i]);
  }
}

template <typename Bytes, int n>
void window_row(WindowRow<std::uint8_t> row) {
  using Pixel = Column<Bytes, n>;
  const auto column = [&](int x) {
    return Pixel::load(row.sums + static_cast<std::ptrdiff_t>(std::clamp(x, 0, row.width - 1)) * n * Bytes::kCount);
  };
  Pixel sum = Pixel::all(0);
  for (int x = -row.radius; x <= row.radius; ++x) sum += column(row.extent.begin + x);
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    sum.store(row.costs + static_cast<std::ptrdiff_t>(x) * n * Bytes::kCount);
    sum -= column(x - row.radius);
    sum += column(x + row.radius + 1);
  }
}

/// Sums over windows that move along a row, of each plane of sums. `Take` gets the pixels of the extent.
template <typename Sum, typename Row, typename Take>
void moving_window(const Row& row, int planes, std::ptrdiff_t plane_stride, Take take) {
  const auto column = [&](int plane, int x) {
    return row.sums + plane * plane_stride + static_cast<std::ptrdiff_t>(std::clamp(x, 0, row.width - 1)) * row.lanes;
  };
  std::fill_n(row.window, planes * row.lanes, Sum{0});
  for (int plane = 0; plane < planes; ++plane) {
    Sum* window = row.window + plane * row.lanes;
    for (int x = row.extent.begin - row.radius; x <= row.extent.begin + row.radius; ++x) {
      for (int d = 0; d < row.lanes; ++d) window[d] = static_cast<Sum>(window[d] + column(plane, x)[d]);
    }
  }
  for (int x = row.extent.begin; x < row.extent.end; ++x) {
    take(x);
    for (int plane = 0; plane < planes; ++plane) {
      const Sum *enters = column(plane, x + row.radius + 1), *leaves = column(plane, x - row.radius);
      Sum* window = row.window + plane * row.lanes;
      for (int d = 0; d < row.lanes; ++d) window[d] = static_cast<Sum>(window[d] + enters[d] - leaves[d]);
    }
  }
}

inline void window_row_wide(const WindowRow<std::uint16_t>& row) {
  moving_window<std::uint16_t>(row, 1, 0, [&](int x) {
    std::uint8_t* costs = row.costs + static_cast<std::ptrdiff_t>(x) * row.lanes;
    for (int d = 0; d < row.lanes; ++d) costs[d] = static_cast<std::uint8_t>(row.window[d] * row.factor >> 16);
  });
}

template <typename Each>
void each_pair(const ProductRow& row, Each each) {
  for (int x = 0; x < row.width; ++x) {
    const std::uint8_t* right = row.right + row.width - 1 - x + row.first[x];
    each(row.left[x], right, row.sums + static_cast<std::ptrdiff_t>(x) * row.lanes);
  }
}

inline void square_row(const ProductRow& row) {
  const int sign = row.enters ? 1 : -1;
  each_pair(row, [&](int left, const std::uint8_t* right, std::int32_t* sums) {
    for (int d = 0; d < row.lanes; ++d) sums[d] += sign * (left - right[d]) * (left - right[d]);
  });
}

/// Sums of the right image's grey values, of their squares, and of the products of both images.
inline void correlation_row(const ProductRow& row) {
  const int sign = row.enters ? 1 : -1;
  each_pair(row, [&](int left, const std::uint8_t* right, std::int32_t* sums) {
    std::int32_t* squares = sums + row.sum_stride;
    std::int32_t* products = squares + row.sum_stride;
    for (int d = 0; d < row.lanes; ++d) {
      const int value = sign * right[d];
      sums[d] += value;
      squares[d] += value * right[d];
      products[d] += value * left;
    }
  });
}

template <typename Cost>
void limited_costs(const ProductCostRow& row, int x, Cost cost) {
  const std::uint8_t* limits = row.right_limits + row.width - 1 - x + row.first[x];
  std::uint8_t* costs = row.costs + static_cast<std::ptrdiff_t>(x) * row.lanes;
  for (int d = 0; d < row.lanes; ++d) {
    const auto value = static_cast<int>(std::min(cost(d), row.most));
    costs[d] = static_cast<std::uint8_t>(std::max(value, static_cast<int>(limits[d])));
  }
}

inline void square_cost_row(const ProductCostRow& row) {
  moving_window<std::int32_t>(row, 1, row.sum_stride, [&](int x) {
    limited_costs(row, x, [&](int d) { return row.scale * static_cast<float>(row.window[d]); });
  });
}

/// 1 minus the correlation, as a share of the most cost; patches that correlate negatively cost the most, too.
inline void correlation_cost_row(const ProductCostRow& row) {
  // Differences of large products fit into 32 bits even where the products do not: they are taken modulo 2^32.
  const auto count = static_cast<std::uint32_t>((2 * row.radius + 1) * (2 * row.radius + 1));
  const auto spread_of = [count](std::int32_t products, std::int32_t a, std::int32_t b) {
    const std::uint32_t both = static_cast<std::uint32_t>(a) * static_cast<std::uint32_t>(b);
    return static_cast<float>(static_cast<std::int32_t>(count * static_cast<std::uint32_t>(products) - both));
  };
  const std::int32_t* sums = row.window;
  const std::int32_t* squares = row.window + row.lanes;
  const std::int32_t* products = squares + row.lanes;
  moving_window<std::int32_t>(row, 3, row.sum_stride, [&](int x) {
    const std::int32_t left = row.left_sums[x];
    const float left_spread = spread_of(row.left_squares[x], left, left);
    limited_costs(row, x, [&](int d) {
      const float right_spread = spread_of(squares[d], sums[d], sums[d]);
      const float common = spread_of(products[d], left, sums[d]);
      const float spread = std::sqrt(std::max(left_spread * right_spread, 1.0F));
      return row.most * (1.0F - std::max(common / spread, 0.0F));
    });
  });
}

}  // namespace
}  // namespace raybundle
