// What every process of the project does around its own class: options, signals, the Bus, exit
// codes.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "libs/bus/bus.hpp"

namespace CLI {
class App;
}

namespace fusion_slam {

// Parses --help, --lcm-url, --mode live|throughput|lockstep; opens the Bus; `make` builds the
// process's object, which subscribes in its constructor; runs until SIGINT, SIGTERM or COMMAND
// quit. Returns 0 stopped as asked, 1 failed (said on stderr, with the process's name), 2 wrong
// usage. `add_options` adds the process's own options before they are parsed.
int process_main(int argc, char** argv, const std::string& name, const std::string& description,
                 const std::function<std::shared_ptr<void>(Bus&)>& make,
                 const std::function<void(CLI::App&)>& add_options = {});

// "live", "throughput", "lockstep".
const char* to_string(Mode mode);

}  // namespace fusion_slam
