// Reads the text of one .lcm file: `package`, `struct`, members, `const`.
#pragma once

#include <string>
#include <vector>

#include "libs/schema/schema.hpp"

namespace fusion_slam {

// The file's structs, in its order; nested types are named (with their package) but not yet linked.
// Throws std::runtime_error "file:line: what was expected".
std::vector<LcmType> parse_lcm(const std::string& file, const std::string& text);

}  // namespace fusion_slam
