// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace raybundle {

/// Memory that begins with a cache line: a column of 64 disparities then is one line, not parts of two.
template <typename Value>
struct CacheAligned {
  using value_type = Value;
  static constexpr std::align_val_t kLine{64};

  CacheAligned() = default;
  template <typename Other>
  CacheAligned(const CacheAligned<Other>&) {}  // NOLINT(google-explicit-constructor): what an allocator has to have

  Value* allocate(std::size_t count) { return static_cast<Value*>(::operator new(count * sizeof(Value), kLine)); }
  void deallocate(Value* memory, std::size_t) { ::operator delete(memory, kLine); }
  friend bool operator==(const CacheAligned&, const CacheAligned&) { return true; }
};

/// Columns of disparities of a row or an image.
using Columns = std::vector<std::uint8_t, CacheAligned<std::uint8_t>>;

}  // namespace raybundle
