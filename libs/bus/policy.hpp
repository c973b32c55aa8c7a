// How a listener treats messages, and what drives it.
#pragma once

namespace fusion_slam {

// What happens to messages that wait while a callback runs.
enum class Policy {
  kKeepAll,     // all are handled, in order; beyond `keep_all_bound` the oldest are dropped and
                // counted
  kLatestOnly,  // live: only the newest is kept, the others are dropped and counted; offline: as
                // kKeepAll
};

enum class Mode {
  kLive,        // the robot's clock drives: latest-only drops, late input is waited for up to
                // merge_wait_us
  kThroughput,  // a replay bounds what is in flight: nothing is dropped, order as in kLive
  kLockstep,    // a replay says by STEP what to handle and when: byte-identical results
};

}  // namespace fusion_slam
