// The OpenNI2 runtime: started with the first user, shut down with the last. It loads every driver
// plug-in (lib*.so.0) of the folder OpenNI2/Drivers beside its own library, and these look for
// devices. Another runtime with other plug-ins (Orbbec's, the virtual device's) is chosen by
// LD_LIBRARY_PATH.
#pragma once

#include <atomic>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <OniCAPI.h>

namespace fusion_slam {

// What a device or the runtime did not do; says why and what to do.
struct CameraError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct CameraCandidate {
  std::string uri;
  std::string name;  // vendor and name
};

// One at a time in a process (the runtime is a global thing).
class OpenniRuntime {
 public:
  OpenniRuntime();  // throws CameraError
  ~OpenniRuntime();
  OpenniRuntime(const OpenniRuntime&) = delete;
  OpenniRuntime& operator=(const OpenniRuntime&) = delete;

  std::vector<CameraCandidate> devices() const;

  // Set by the runtime's own threads.
  bool gone() const { return gone_; }    // a device was unplugged since clear()
  bool ended() const { return ended_; }  // a recording came to its end
  void clear() { gone_ = ended_ = false; }

 private:
  OniCallbackHandle callbacks_ = nullptr;
  std::atomic<bool> gone_{false};
  std::atomic<bool> ended_{false};
};

// "2 devices: ..." or what to do when there is none.
std::string describe(const std::vector<CameraCandidate>& devices);

// What the runtime says about its last failure, as the end of a sentence.
std::string openni_reason();

}  // namespace fusion_slam
