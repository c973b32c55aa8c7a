// `fusion-slam run`: a log in, a trajectory and maps out.
#pragma once

#include "logplayer/run/options.hpp"

namespace fusion_slam {

// Returns the exit code: 0 done, 1 failed (said on stderr; what there was until then is written),
// 130 interrupted.
int run_log(const RunOptions& options);

}  // namespace fusion_slam
