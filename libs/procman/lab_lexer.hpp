// Words of a procman configuration file. Used by lab_config.cpp only.
#pragma once

#include <string>
#include <vector>

namespace fusion_slam {

struct LabToken {
  enum class Kind { kWord, kString, kNumber, kSign, kEnd };
  Kind kind = Kind::kEnd;
  std::string text;  // of a string: without its quotes, escapes resolved
  int line = 1;
  int column = 1;
};

// Ends with a kEnd token. Words are letters, digits, _ - .; signs are { } = ;. A `#` begins a
// comment. In strings \" \\ \n \t are escapes, other backslashes stay. Throws LabConfigError with
// `name`, line and column.
std::vector<LabToken> tokenise_lab(const std::string& text, const std::string& name);

}  // namespace fusion_slam
