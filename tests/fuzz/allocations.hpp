// Counts what a piece of code allocates, under the sanitizers' allocator.
#pragma once

#include <cstddef>

#include <sanitizer/allocator_interface.h>

namespace fusion_slam {

inline std::size_t& allocated_bytes() {
  static std::size_t bytes = 0;
  return bytes;
}

// Call once before counting.
inline void count_allocations() {
  static const int installed = __sanitizer_install_malloc_and_free_hooks(
      [](const volatile void*, std::size_t size) { allocated_bytes() += size; },
      [](const volatile void*) {});
  static_cast<void>(installed);
}

}  // namespace fusion_slam
