// link: fs_journal
// Any bytes as a journal: what is whole before the first damage is handed over, opening it cuts off
// the rest, and what is written then is read again. Nothing is allocated beyond a few times the
// file.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "libs/journal/journal.hpp"
#include "tests/fuzz/allocations.hpp"
#include "tests/fuzz/temporary_folder.hpp"

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

void write_file(const std::string& path, const std::uint8_t* data, std::size_t size) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using fusion_slam::Journal;
  fusion_slam::count_allocations();
  const std::string path = fusion_slam::temporary_folder() / "journal";
  // As it is: random bytes are hardly ever whole records.
  write_file(path, data, size);
  const std::size_t before = fusion_slam::allocated_bytes();
  const auto found = fusion_slam::read_journal(path, {});
  require(fusion_slam::allocated_bytes() - before <= 8 * size + 65536);
  require(found.whole_bytes + found.cut_bytes == static_cast<std::int64_t>(size));
  // As the messages of a journal that is cut and damaged: the input says where.
  std::filesystem::remove(path);
  std::int64_t written = 0;
  {
    Journal journal(path);
    for (std::size_t at = 0; at + 1 < size && written < 8; ++written) {
      const std::size_t n = std::min<std::size_t>(data[at], size - at - 1);
      require(journal.append(static_cast<std::int64_t>(at), "CHANNEL", data + at + 1, n));
      at += n + 1;
    }
  }
  const std::size_t whole = std::filesystem::file_size(path);
  if (size >= 4 && whole > 0) {
    std::filesystem::resize_file(path, data[0] * whole / 255);
    const std::size_t left = std::filesystem::file_size(path);
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(left == 0 ? 0 : data[1] * left / 256));
    if (left > 0) file.put(static_cast<char>(data[2]));
  }
  try {
    std::int64_t n = 0;
    {
      Journal journal(path);
      n = journal.state().n_records;
      require(n <= written);
      require(journal.append(1, "NEXT", data, size));
    }
    std::string last;
    const auto again = fusion_slam::read_journal(
        path, [&](const fusion_slam::LogEvent& event) { last = event.channel; });
    require(again.n_records == n + 1 && again.cut_bytes == 0 && last == "NEXT");
  } catch (const std::runtime_error&) {  // its first bytes say that it is something else
  }
  return 0;
}
