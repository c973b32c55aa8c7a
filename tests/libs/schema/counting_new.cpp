#include "tests/libs/schema/counting_new.hpp"

#include <cstdlib>
#include <new>

namespace {
std::size_t total_bytes = 0;
}

std::size_t fusion_slam::allocated_bytes() { return total_bytes; }

void* operator new(std::size_t size) {
  total_bytes += size;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
