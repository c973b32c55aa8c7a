#include "logplayer/import/log_output.hpp"

#include "libs/messages/models.hpp"

namespace fusion_slam {
namespace {

constexpr std::int64_t kModelPeriodUs = 1'000'000;

}  // namespace

void LogOutput::write_models(std::int64_t utime_us) {
  if (utime_us < next_models_us_) return;
  next_models_us_ = utime_us + kModelPeriodUs;
  ++models_seq_;
  auto robot = to_message(config_.robot, utime_us);
  robot.seq = models_seq_;
  encode(utime_us, "ROBOT_MODEL", robot);
  if (!config_.robot.has_camera) return;
  auto camera = to_message(config_.camera, utime_us);
  camera.seq = models_seq_;
  encode(utime_us, "CAMERA_MODEL", camera);
}

}  // namespace fusion_slam
