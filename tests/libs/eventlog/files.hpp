// Small files in a folder of its own that goes away with the object.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <unistd.h>

#include "libs/schema/big_endian.hpp"

namespace fusion_slam {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern =
        (std::filesystem::temp_directory_path() / "fusion-slam-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

// A number as the log holds it.
inline std::string big_endian(std::int64_t value, std::size_t n_bytes) {
  std::string text(n_bytes, '\0');
  write_big_endian(static_cast<std::uint64_t>(value), n_bytes,
                   reinterpret_cast<std::uint8_t*>(text.data()));
  return text;
}

// An event written by hand, byte for byte.
inline std::string event_bytes(std::int64_t number, std::int64_t timestamp_us,
                               const std::string& channel, const std::string& data) {
  return std::string("\xED\xA1\xDA\x01") + big_endian(number, 8) + big_endian(timestamp_us, 8) +
         big_endian(static_cast<std::int64_t>(channel.size()), 4) +
         big_endian(static_cast<std::int64_t>(data.size()), 4) + channel + data;
}

inline std::vector<std::uint8_t> to_bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

}  // namespace fusion_slam
