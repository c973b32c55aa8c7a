// A directory that appears whole or not at all: written beside its place, brought to the disk, then
// exchanged in one step of the file system (renameat2). Whoever is killed at any moment leaves the
// old directory or the new one, never a mixture; what lies beside it is called
// DIR.partial-PID-N and is removed by the next save.
#pragma once

#include <filesystem>

namespace fusion_slam {

// One thread at a time; two programs that save to one place at once: the later one stands.
class AtomicDirectory {
 public:
  // Makes the directory beside `target`. Throws std::runtime_error: it can't be made there.
  explicit AtomicDirectory(const std::filesystem::path& target);
  // Without commit(): removes what was written.
  ~AtomicDirectory();
  AtomicDirectory(const AtomicDirectory&) = delete;
  AtomicDirectory& operator=(const AtomicDirectory&) = delete;

  // Where to write.
  const std::filesystem::path& path() const { return partial_; }

  // Brings all its files to the disk and puts it in the place of `target`; what was there is
  // removed afterwards. Throws std::runtime_error; `target` is then what it was before.
  void commit();

 private:
  std::filesystem::path target_;
  std::filesystem::path partial_;
};

}  // namespace fusion_slam
