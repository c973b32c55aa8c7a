// Memory that malloc keeps after it was freed.
#pragma once

#include <cstddef>

#include <malloc.h>

namespace fusion_slam {

// Gives freed memory back to the system when there is more of it than so many bytes; true: it did.
// glibc by itself keeps what a large temporary computation took, in each thread's arena, for good
// (up to 64 MB each once large blocks have been freed: mallopt(3), M_MMAP_THRESHOLD, is dynamic).
// Takes milliseconds for 100 MB. Any thread.
inline bool give_back_memory(std::size_t above_bytes) {
  return mallinfo2().fordblks > above_bytes && malloc_trim(0) == 1;
}

}  // namespace fusion_slam
