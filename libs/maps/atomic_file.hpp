// A file appears whole or not at all.
#pragma once

#include <filesystem>
#include <string>

namespace fusion_slam {

// Writes FILE.partial, then renames it. Throws std::runtime_error with the file, the reason and
// what to do; FILE is then what it was before, and no FILE.partial is left.
void write_file_atomically(const std::filesystem::path& file, const std::string& bytes);

}  // namespace fusion_slam
