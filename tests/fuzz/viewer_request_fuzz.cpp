// link: fs_viewer
// Whatever a browser (or somebody who says to be one) sends: a request or a reason, never more
// memory than the text deserves.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "viz/web/admission.hpp"
#include "viz/web/protocol.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::string why;
  const auto request = fusion_slam::parse_request(text, &why);
  if (!request && why.empty()) std::abort();
  if (request && request->target.size() > 200) std::abort();
  fusion_slam::is_our_host(text, {"robot"});
  fusion_slam::is_our_page(text, "robot:8090");
  return 0;
}
