#include "drivers/rplidar/port_finder.hpp"

#include <algorithm>
#include <cstdio>

#include <glob.h>
#include <libserialport.h>

namespace fusion_slam {
namespace {

// Silicon Labs CP210x, on the adapters of all models.
constexpr int kVendor = 0x10C4;
constexpr int kProduct = 0xEA60;

PortCandidate describe(const sp_port* port) {
  PortCandidate candidate;
  candidate.path = sp_get_port_name(port);
  if (const char* text = sp_get_port_description(port)) candidate.description = text;
  int vendor = 0;
  int product = 0;
  if (sp_get_port_transport(port) == SP_TRANSPORT_USB &&
      sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK) {
    char ids[16];
    std::snprintf(ids, sizeof ids, ", %04X:%04X", static_cast<unsigned>(vendor) & 0xFFFFU,
                  static_cast<unsigned>(product) & 0xFFFFU);
    candidate.description += ids;
    candidate.likely = vendor == kVendor && product == kProduct;
  }
  return candidate;
}

}  // namespace

std::vector<PortCandidate> serial_ports() {
  std::vector<PortCandidate> found;
  sp_port** ports = nullptr;
  if (sp_list_ports(&ports) != SP_OK) return found;
  for (sp_port** port = ports; *port != nullptr; ++port) found.push_back(describe(*port));
  sp_free_port_list(ports);
  std::sort(found.begin(), found.end(), [](const PortCandidate& a, const PortCandidate& b) {
    return a.likely != b.likely ? a.likely : a.path < b.path;
  });
  return found;
}

std::vector<std::string> ports_to_try(const std::string& port) {
  std::vector<std::string> paths;
  if (port.empty()) {
    for (const PortCandidate& candidate : serial_ports())
      if (candidate.likely) paths.push_back(candidate.path);
  } else if (port.find_first_of("*?") == std::string::npos) {
    paths.push_back(port);
  } else {
    glob_t matches{};
    if (glob(port.c_str(), 0, nullptr, &matches) == 0)
      for (std::size_t i = 0; i < matches.gl_pathc; ++i) paths.emplace_back(matches.gl_pathv[i]);
    globfree(&matches);
  }
  return paths;
}

std::string describe_ports(const std::vector<PortCandidate>& ports) {
  if (ports.empty()) return "this machine has no serial port";
  std::string text = "ports here: ";
  for (const PortCandidate& port : ports) {
    if (&port != &ports.front()) text += ", ";
    text += port.path;
    if (!port.description.empty()) text += " (" + port.description + ")";
  }
  return text;
}

}  // namespace fusion_slam
