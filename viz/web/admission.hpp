// Who may talk to the viewer. A page of another site, opened in the same browser, must not drive
// the robot, and a name that somebody points at this machine (DNS rebinding) must not pass for it.
// Pure functions.
#pragma once

#include <set>
#include <string>
#include <string_view>

namespace fusion_slam {

// The host of "host", "host:port", "[::1]:port"; lower case. Empty when it is none.
std::string host_name_of(std::string_view host);

// A request with this Host header is meant for us: an address literal, localhost, or one of our
// names (lower case).
bool is_our_host(std::string_view host, const std::set<std::string>& our_names);

// A WebSocket may be opened: the Origin header is missing (no browser) or is the very Host of the
// request.
bool is_our_page(std::string_view origin, std::string_view host);

}  // namespace fusion_slam
