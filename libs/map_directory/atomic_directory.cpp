#include "libs/map_directory/atomic_directory.hpp"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& doing, const std::string& why) {
  throw std::runtime_error(path.string() + ": " + doing + ": " + why +
                           "; choose another place, or free space there");
}

void sync_to_disk(const fs::path& path, int flags) {
  const int file = open(path.c_str(), flags | O_CLOEXEC);
  if (file < 0) fail(path, "can't be opened", std::strerror(errno));
  const bool good = fsync(file) == 0;
  const int error = errno;
  close(file);
  if (!good) fail(path, "can't be brought to the disk", std::strerror(error));
}

// DIR and DIR/ are the same place; a link stands for what it points to.
fs::path without_slash(const fs::path& path) {
  const fs::path whole = fs::weakly_canonical(fs::absolute(path));
  return whole.has_filename() ? whole : whole.parent_path();
}

std::string prefix_of(const fs::path& target) { return target.filename().string() + ".partial-"; }

// What savers left that were killed. A saver that still runs keeps its own.
void remove_leftovers(const fs::path& target) {
  const std::string prefix = prefix_of(target);
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(target.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(prefix, 0) != 0) continue;
    const long pid = std::strtol(name.c_str() + prefix.size(), nullptr, 10);
    if (pid <= 0 || pid == getpid()) continue;
    if (kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH)
      fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

AtomicDirectory::AtomicDirectory(const fs::path& target) : target_(without_slash(target)) {
  std::error_code error;
  fs::create_directories(target_.parent_path(), error);
  if (error) fail(target_.parent_path(), "can't be made", error.message());
  remove_leftovers(target_);
  for (int n = 0; n < 1000; ++n) {
    partial_ = target_.parent_path() /
               (prefix_of(target_) + std::to_string(getpid()) + "-" + std::to_string(n));
    if (fs::create_directory(partial_, error)) return;
    if (error) break;
  }
  fail(partial_, "can't be made", error ? error.message() : "it exists");
}

AtomicDirectory::~AtomicDirectory() {
  std::error_code ignored;
  if (!partial_.empty()) fs::remove_all(partial_, ignored);
}

void AtomicDirectory::commit() {
  for (const auto& entry : fs::recursive_directory_iterator(partial_))
    sync_to_disk(entry.path(), O_RDONLY);
  sync_to_disk(partial_, O_RDONLY | O_DIRECTORY);
  const bool replaces = fs::exists(fs::symlink_status(target_));
  const unsigned how = replaces ? RENAME_EXCHANGE : RENAME_NOREPLACE;
  if (renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, target_.c_str(), how) != 0) {
    const int error = errno;
    // A file system without this call (NFS): a plain rename is as good where nothing is replaced.
    if (replaces || error != EINVAL || std::rename(partial_.c_str(), target_.c_str()) != 0)
      fail(target_, replaces ? "can't be replaced in one step" : "can't be put in its place",
           std::strerror(error));
  }
  sync_to_disk(target_.parent_path(), O_RDONLY | O_DIRECTORY);
  std::error_code ignored;
  if (replaces) fs::remove_all(partial_, ignored);  // what was there before
  partial_.clear();
}

}  // namespace fusion_slam
