#pragma once

#include <cstddef>

/// Counts the heap allocations of an executable, for tests that a loop makes none. Sanitizers bring
/// an allocator of their own: nothing is counted then.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

inline constexpr bool kCountsAllocations = false;
inline long AllocationsOfThisThread() { return 0; }
inline std::size_t LargestAllocationOfThisThread() { return 0; }
inline void ForgetLargestAllocation() {}

#else

inline constexpr bool kCountsAllocations = true;
inline thread_local long allocations_of_this_thread = 0;
inline long AllocationsOfThisThread() { return allocations_of_this_thread; }
inline thread_local std::size_t largest_allocation_of_this_thread = 0;
/// Bytes, of one call.
inline std::size_t LargestAllocationOfThisThread() { return largest_allocation_of_this_thread; }
inline void ForgetLargestAllocation() { largest_allocation_of_this_thread = 0; }

inline void CountAllocation(std::size_t size) {
  ++allocations_of_this_thread;
  if (size > largest_allocation_of_this_thread) largest_allocation_of_this_thread = size;
}

// operator new and Eigen both end here. glibc lets a program put its own in front: one of those
// that several source files bring.
// NOLINTBEGIN(misc-definitions-in-headers,readability-inconsistent-declaration-parameter-name)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_realloc(void*, std::size_t);

[[gnu::weak]] void* malloc(std::size_t size) {
  CountAllocation(size);
  return __libc_malloc(size);
}
[[gnu::weak]] void* realloc(void* old, std::size_t size) {
  CountAllocation(size);
  return __libc_realloc(old, size);
}
}
// NOLINTEND(misc-definitions-in-headers,readability-inconsistent-declaration-parameter-name)

#endif
