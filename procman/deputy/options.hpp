// The deputy's command line.
#pragma once

#include <optional>

#include "procman/deputy/deputy.hpp"

namespace fusion_slam {

// Nothing: exit with *exit_code (help was shown, or the usage was wrong). Throws
// std::runtime_error for a user or a folder that does not exist.
std::optional<DeputyOptions> parse_deputy_options(int argc, char** argv, int* exit_code);

}  // namespace fusion_slam
