// link: fs_camera_messages fs_schema
// CAMERA messages as the bus hands them over: guarded, decoded, turned into a frame.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "bot_core/images_t.hpp"
#include "libs/camera_messages/images.hpp"
#include "libs/schema/guard.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fusion_slam::LcmType* type = fusion_slam::peek_type(data, size);
  if (type == nullptr || fusion_slam::check(*type, data, size)) return 0;
  bot_core::images_t message;
  if (message.decode(data, 0, static_cast<int>(size)) < 0) return 0;
  std::string why;
  const auto frame = fusion_slam::from_message(message, &why);
  if (frame && frame->depth_mm.size() != frame->colour_bgr.size()) std::abort();
  if (!frame && why.empty()) std::abort();
  return 0;
}
