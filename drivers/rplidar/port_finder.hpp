// Where an RPLidar may be plugged in.
#pragma once

#include <string>
#include <vector>

namespace fusion_slam {

struct PortCandidate {
  std::string path;
  std::string description;  // for people: "CP2102 USB to UART Bridge Controller, 10C4:EA60"
  bool likely = false;  // the adapter that Slamtec ships (CP210x); only these are asked unbidden
};

// All serial ports of this machine, likely ones first, then by name.
std::vector<PortCandidate> serial_ports();

// What a configuration's port stands for: nothing: the likely ports; a pattern with * or ?: what
// matches it, sorted; a path: itself, whether it exists or not.
std::vector<std::string> ports_to_try(const std::string& port);

// "ports here: /dev/ttyUSB0 (CP2102 ...), /dev/ttyS0" or "this machine has no serial port".
std::string describe_ports(const std::vector<PortCandidate>& ports);

}  // namespace fusion_slam
