#include "viz/web/admission.hpp"

#include <algorithm>
#include <cctype>

#include <arpa/inet.h>

namespace fusion_slam {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

bool is_address(const std::string& name) {
  unsigned char bytes[sizeof(in6_addr)];
  return inet_pton(AF_INET, name.c_str(), bytes) == 1 ||
         inet_pton(AF_INET6, name.c_str(), bytes) == 1;
}

}  // namespace

std::string host_name_of(std::string_view host) {
  if (host.empty()) return "";
  if (host.front() == '[') {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? "" : lower(host.substr(1, end - 1));
  }
  return lower(host.substr(0, host.find(':')));
}

bool is_our_host(std::string_view host, const std::set<std::string>& our_names) {
  const std::string name = host_name_of(host);
  return !name.empty() && (name == "localhost" || is_address(name) || our_names.count(name) > 0);
}

bool is_our_page(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  const std::string text = lower(origin);
  for (const char* scheme : {"http://", "https://"})
    if (text.rfind(scheme, 0) == 0)
      return text.substr(std::string_view(scheme).size()) == lower(host);
  return false;
}

}  // namespace fusion_slam
