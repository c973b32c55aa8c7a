#include "libs/maps/atomic_file.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace fusion_slam {

void write_file_atomically(const std::filesystem::path& file, const std::string& bytes) {
  const std::filesystem::path partial = file.string() + ".partial";
  const auto fail = [&](const std::string& why) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw std::runtime_error(file.string() + ": not written: " + why +
                             "; free space there or choose another directory");
  };
  {
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    if (!out) fail(std::strerror(errno));
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.flush();
    if (!out) fail(std::strerror(errno));
  }
  std::error_code error;
  std::filesystem::rename(partial, file, error);
  if (error) fail(error.message());
}

}  // namespace fusion_slam
