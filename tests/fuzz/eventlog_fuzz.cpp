// link: fs_eventlog fs_verify fs_info
// Any bytes as an event log: refused with a runtime_error, or read to the end, in order, without
// allocating more than a few times the file; `info` and `verify` say something of it.
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

#include <sys/mman.h>
#include <unistd.h>

#include "libs/eventlog/reader.hpp"
#include "logplayer/info/report.hpp"
#include "logplayer/verify/verifier.hpp"
#include "tests/fuzz/allocations.hpp"

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

void read_all(const std::string& path, std::size_t size) {
  fusion_slam::LogReader reader(path);
  fusion_slam::LogEvent event;
  std::int64_t last = -1;
  std::size_t sum = 0;
  do {
    const std::size_t before = fusion_slam::allocated_bytes();
    while (reader.next(&event)) {
      require(event.offset_bytes > last);
      last = event.offset_bytes;
      sum += event.data.size() + event.channel.size() + 28;
    }
    require(fusion_slam::allocated_bytes() - before <= 8 * size + 4096);
  } while (reader.damage() && reader.resync());
  require(sum <= size);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fusion_slam::count_allocations();
  const int file = memfd_create("fuzz", 0);
  require(file >= 0 && write(file, data, size) == static_cast<ssize_t>(size));
  const std::string path = "/proc/self/fd/" + std::to_string(file);
  try {
    read_all(path, size);
    fusion_slam::LogReader for_info(path);
    fusion_slam::json_report("fuzz", fusion_slam::summarise(for_info));
    for_info.seek(0);
    fusion_slam::text_report("fuzz", fusion_slam::summarise(for_info));
    fusion_slam::LogReader for_verify(path);
    fusion_slam::text_report("fuzz", fusion_slam::verify(for_verify), 10);
  } catch (const std::runtime_error&) {
  }
  close(file);
  return 0;
}
