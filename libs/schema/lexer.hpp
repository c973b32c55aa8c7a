// Splits the text of a .lcm file into words, numbers and punctuation; comments (// and /* */) are
// left out.
#pragma once

#include <string>
#include <vector>

namespace fusion_slam {

struct LcmToken {
  std::string text;  // empty: the end of the file
  int line = 0;
};

// Throws std::runtime_error "file:line: ..." for a character that no .lcm file has, or a comment
// that never ends.
std::vector<LcmToken> lcm_tokens(const std::string& file, const std::string& text);

}  // namespace fusion_slam
