// Bytes that this program has asked operator new for so far.
#pragma once

#include <cstddef>

namespace fusion_slam {

std::size_t allocated_bytes();

}  // namespace fusion_slam
