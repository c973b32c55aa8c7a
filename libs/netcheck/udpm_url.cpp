#include "libs/netcheck/udpm_url.hpp"

#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <stdexcept>

#include <arpa/inet.h>

namespace fusion_slam {
namespace {

long number(const std::string& url, const std::string& what, const std::string& text, long low,
            long high) {
  char* end = nullptr;
  errno = 0;
  const long value = std::strtol(text.c_str(), &end, 10);
  if (text.empty() || *end != '\0' || errno != 0 || value < low || value > high) {
    throw std::invalid_argument("LCM URL " + url + ": " + what + " `" + text +
                                "` has to be a number from " + std::to_string(low) + " to " +
                                std::to_string(high));
  }
  return value;
}

}  // namespace

UdpmUrl parse_udpm_url(const std::string& given) {
  std::string url = given;
  if (url.empty()) {
    const char* environment = std::getenv("LCM_DEFAULT_URL");
    url = environment == nullptr || *environment == '\0' ? "udpm://" : environment;
  }
  const std::string scheme = "udpm://";
  if (url.compare(0, scheme.size(), scheme) != 0) {
    throw std::invalid_argument(
        "LCM URL " + url + " is no multicast (udpm://239.255.76.67:7667?ttl=1): nothing to check");
  }
  UdpmUrl result;
  const std::size_t question = url.find('?');
  const std::string address = url.substr(
      scheme.size(), question == std::string::npos ? question : question - scheme.size());
  const std::size_t colon = address.find(':');
  if (!address.substr(0, colon).empty()) result.group = address.substr(0, colon);
  if (colon != std::string::npos) {
    result.port =
        static_cast<std::uint16_t>(number(url, "port", address.substr(colon + 1), 1, 65535));
  }
  in_addr ip{};
  if (inet_pton(AF_INET, result.group.c_str(), &ip) != 1 || !IN_MULTICAST(ntohl(ip.s_addr))) {
    throw std::invalid_argument("LCM URL " + url + ": `" + result.group +
                                "` is no multicast address (224.0.0.0 to 239.255.255.255)");
  }
  std::istringstream options(question == std::string::npos ? "" : url.substr(question + 1));
  for (std::string option; std::getline(options, option, '&');) {
    const std::size_t equals = option.find('=');
    const std::string key = option.substr(0, equals);
    const std::string value = equals == std::string::npos ? "" : option.substr(equals + 1);
    if (key == "ttl") result.ttl = static_cast<int>(number(url, key, value, 0, 255));
    if (key == "recv_buf_size")
      result.recv_buf_size_bytes = static_cast<int>(number(url, key, value, 1, 1L << 30));
  }
  return result;
}

}  // namespace fusion_slam
