// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Counts every call that asks the C library for memory, whoever makes it: operator new, aligned or not, and Eigen, which
// asks for itself. What ships on a device takes its memory at the start, and its tests hold the loop against that. Include
// it in one source of a binary only: it stands in for the library's functions. Sanitizers have the heap for themselves:
// under them nothing is counted.
#include <atomic>
#include <cstdlib>

namespace raybundle::testing {
std::atomic<long> heap_calls{0};
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool kHeapIsCounted = true;
#else
inline constexpr bool kHeapIsCounted = false;
#endif
}  // namespace raybundle::testing

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
extern "C" {
void* library_malloc(std::size_t size) noexcept __asm__("__libc_malloc");
void* library_calloc(std::size_t count, std::size_t size) noexcept __asm__("__libc_calloc");
void* library_realloc(void* memory, std::size_t size) noexcept __asm__("__libc_realloc");
void* library_memalign(std::size_t alignment, std::size_t size) noexcept __asm__("__libc_memalign");

void* malloc(std::size_t size) noexcept {
  ++raybundle::testing::heap_calls;
  return library_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) noexcept {
  ++raybundle::testing::heap_calls;
  return library_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) noexcept {
  ++raybundle::testing::heap_calls;
  return library_realloc(memory, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  ++raybundle::testing::heap_calls;
  return library_memalign(alignment, size);
}
}
#endif
