// What `fusion-slam lab` does.
#pragma once

#include <atomic>

#include "procman/sheriff/options.hpp"

namespace fusion_slam {

// Returns the exit code. *stop (Ctrl-C) ends what waits or watches. Throws LabConfigError,
// OtherSheriff, std::runtime_error.
int run_sheriff(const SheriffOptions& options, const std::atomic<bool>* stop);

}  // namespace fusion_slam
