// Text files of eight numbers a line, which TUM trajectories and relations files both are.
// Blank lines and lines whose first visible character is # are skipped; CR LF is accepted.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <istream>
#include <stdexcept>
#include <string>
#include <vector>

namespace fusion_slam {

// what() is "FILE:LINE: reason" or "FILE: reason".
class FileError : public std::runtime_error {
 public:
  FileError(const std::string& file, std::size_t line, const std::string& reason);
  FileError(const std::string& file, const std::string& reason);
};

struct NumberRow {
  std::size_t line = 0;  // 1 is the first line of the file
  std::array<double, 8> values{};
};

// `columns` names the eight numbers for error messages: "time x y z qx qy qz qw".
// Throws FileError for: unreadable file, no data line, not exactly eight fields, a field that is
// not a finite number.
std::vector<NumberRow> read_number_rows(std::istream& in, const std::string& name,
                                        const std::string& columns);
std::vector<NumberRow> read_number_rows(const std::filesystem::path& file,
                                        const std::string& columns);

}  // namespace fusion_slam
