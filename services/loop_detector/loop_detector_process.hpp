// Loop detection on the bus: KEYFRAME and GRAPH in; LOOP_CANDIDATE out, and CONSTRAINT for
// candidates that are accepted.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "fusion_slam/camera_model_t.hpp"
#include "fusion_slam/graph_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "fusion_slam/robot_model_t.hpp"
#include "libs/bus/bus.hpp"
#include "services/loop_detector/loop_detector.hpp"

namespace fusion_slam {

// Keyframes that come before CAMERA_MODEL and ROBOT_MODEL wait for them. Both are taken once.
class LoopDetectorProcess {
 public:
  explicit LoopDetectorProcess(Bus& bus, LoopDetectorConfig config = {});

 private:
  void on_camera_model(const camera_model_t& message);
  void on_robot_model(const robot_model_t& message);
  void on_keyframe(const keyframe_t& message);
  void on_graph(const graph_t& message);
  void start_when_ready();
  void detect(LoopKeyframe keyframe);
  void publish_candidate(const LoopCandidate& candidate);
  void publish_constraint(const LoopCandidate& candidate);

  Bus& bus_;
  LoopDetectorConfig config_;
  std::optional<CameraModel> camera_;
  std::optional<SE3> T_base_camera_;
  std::unique_ptr<LoopDetector> detector_;
  std::vector<LoopKeyframe> early_;
  std::int64_t n_candidates_ = 0;
  std::int64_t n_accepted_ = 0;
};

// Nothing, with a reason in `why`, when numbers are not finite or contradict each other.
std::optional<LoopKeyframe> from_message(const keyframe_t& message, std::string* why);

}  // namespace fusion_slam
