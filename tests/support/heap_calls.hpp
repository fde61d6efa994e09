// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts every call of operator new in the binary. What ships on a device takes its memory at the start, and its tests
// hold the loop against that. Include it in one source of a binary only: it replaces the operators.
#include <atomic>
#include <cstdlib>
#include <new>

namespace raybundle::testing {
std::atomic<long> heap_calls{0};
}  // namespace raybundle::testing

// Not inlined: the compiler would see malloc() beside a delete, or free() beside a new, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++raybundle::testing::heap_calls;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
