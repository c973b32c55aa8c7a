#pragma once

#include "logplayer/eval/options.hpp"

namespace fusion_slam {

// Reads, computes, prints the table and writes what was asked for. Returns the program's exit code:
// 0, or 1 with the reason on stderr. Throws FileError.
int run_eval(const EvalOptions& options);

}  // namespace fusion_slam
