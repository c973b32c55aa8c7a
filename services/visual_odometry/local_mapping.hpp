// Local mapping (Mur-Artal et al. 2015, section VI): what happens to the map after a keyframe, on a
// thread of its own.
//
// The thread works on a copy of the part of the map that the keyframe concerns. Tracking goes on
// with the map as it was and takes the result up
// - in a replay (config.wait_for_mapping) at a point that the frames alone decide: after
//   config.mapping_frames frames or before the next keyframe, so that results don't depend on how
//   fast the thread was;
// - live when it is there. Keyframes that come while the thread works join the map at once and
//   share the next job, which is that of the newest: however slow the thread, it is one job behind.
#pragma once

#include <chrono>
#include <cstdint>
#include <future>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/local_bundle_adjustment.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// What a new keyframe concerns.
struct MappingJob {
  std::int64_t newest = 0;
  std::vector<std::int64_t> moving;    // keyframes whose poses are adjusted, ascending
  std::vector<std::int64_t> cullable;  // keyframes that may be forgotten, ascending
  VisualMap part;                      // they, their landmarks and who else sees those
};

struct MappingResult {
  VisualMap part;
  int n_triangulated = 0;
  int n_fused = 0;
  BundleResult bundle;
  int n_landmarks_culled = 0;
  int n_keyframes_culled = 0;
};

MappingJob make_mapping_job(const VisualMap& map, std::int64_t newest,
                            const VisualOdometryConfig& config);

// Triangulate, fuse, adjust, cull. Pure.
MappingResult improve_map(const CameraModel& camera, const MappingJob& job,
                          const std::vector<double>& scale_of_octave,
                          const VisualOdometryConfig& config);

// At most one job at a time. To be used from one thread.
class LocalMapping {
 public:
  LocalMapping(const CameraModel& camera, std::vector<double> scale_of_octave,
               const VisualOdometryConfig& config)
      : camera_(camera), scales_(std::move(scale_of_octave)), config_(config) {}

  bool busy() const { return result_.valid(); }
  // Whether finish() would return at once: in a replay for counting only. Only while busy().
  bool ready() const {
    return result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  void start(MappingJob job);  // not while busy()
  // Waits until the thread is done and puts its result into `map`. Only while busy().
  MappingResult finish(VisualMap* map);

 private:
  CameraModel camera_;
  std::vector<double> scales_;
  VisualOdometryConfig config_;
  MappingJob job_;
  std::future<MappingResult> result_;
};

}  // namespace fusion_slam
