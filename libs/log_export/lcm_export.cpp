#include "libs/log_export/lcm_export.hpp"

#include "fusion_slam/keyframe_image_t.hpp"
#include "libs/eventlog/writer.hpp"

namespace fusion_slam {
namespace {

namespace fs = std::filesystem;
using bot_core::images_t;

// The frame coded anew; false, with a reason, when it can't be read.
bool recode(const LcmExportOptions& options, images_t* message, std::string* why) {
  const auto frame = from_message(*message, why);
  if (!frame) return false;
  const bot_core::image_t* depth = depth_image(*message);
  if (depth == nullptr) return *why = "there is no depth", false;
  images_t coded = options.jpeg_quality > 0
                       ? to_message(*frame, options.jpeg_quality, options.images)
                       : to_message(message->utime, Bytes{}, frame->depth_mm, options.images);
  coded.images[1].utime = depth->utime;
  coded.images[1].nmetadata = depth->nmetadata;
  coded.images[1].metadata = depth->metadata;
  // Everything else of the message stays.
  for (std::size_t i = 0; i < message->images.size(); ++i) {
    if (&message->images[i] == depth) {
      message->image_types[i] = coded.image_types[1];
      message->images[i] = std::move(coded.images[1]);
      break;
    }
  }
  if (options.jpeg_quality > 0)
    for (std::size_t i = 0; i < message->images.size(); ++i)
      if (message->image_types[i] == images_t::LEFT) {
        coded.images[0].utime = message->images[i].utime;
        message->images[i] = std::move(coded.images[0]);
        break;
      }
  return true;
}

template <class Message>
Bytes encoded(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

images_t* images_of(images_t* message) { return message; }
images_t* images_of(keyframe_image_t* message) { return &message->images; }

template <class Message>
Bytes recoded(const LogEvent& event, const LcmExportOptions& options, ExportSummary* summary) {
  auto message = decode_event<Message>(event);
  std::string why = "not a message of its type";
  if (!message || !recode(options, images_of(&*message), &why)) {
    ++summary->skipped[event.channel + ", left as it was: " + why];
    return event.data;
  }
  ++summary->written["of " + event.channel + " coded anew"];
  return encoded(*message);
}

}  // namespace

ExportSummary export_lcm(const fs::path& log, const fs::path& file, const LcmExportOptions& options,
                         const std::function<void(double)>& progress) {
  std::error_code error;
  if (fs::equivalent(log, file, error))
    throw ExportError(file.string() + ": is the log itself; give another file");
  try {
    ExportSummary summary;
    LogWriter writer(file);
    for_each_event(
        log,
        [&](const LogEvent& event) {
          ++summary.written["events"];
          if (event.channel == "CAMERA")
            writer.write(event.timestamp_us, event.channel,
                         recoded<images_t>(event, options, &summary));
          else if (event.channel == "KEYFRAME_IMAGE")
            writer.write(event.timestamp_us, event.channel,
                         recoded<keyframe_image_t>(event, options, &summary));
          else
            writer.write(event.timestamp_us, event.channel, event.data);
        },
        progress);
    writer.close();
    return summary;
  } catch (const ExportError&) {
    throw;
  } catch (const std::runtime_error& failure) {
    throw ExportError(failure.what());
  }
}

}  // namespace fusion_slam
