#include "services/visual_odometry/local_mapping.hpp"

#include <algorithm>
#include <set>

#include "services/visual_odometry/culling.hpp"
#include "services/visual_odometry/landmark_fusion.hpp"
#include "services/visual_odometry/local_map.hpp"
#include "services/visual_odometry/triangulation.hpp"

namespace fusion_slam {
namespace {

std::vector<std::int64_t> landmarks_of(const VisualMap& map, std::int64_t keyframe) {
  std::vector<std::int64_t> ids;
  if (const MapKeyframe* known = map.keyframe(keyframe))
    for (const std::int64_t id : known->landmark_of_feature)
      if (id != 0) ids.push_back(id);
  std::sort(ids.begin(), ids.end());
  return ids;
}

// The newest keyframe and what is fused with it, both ways.
int fuse_around(const CameraModel& camera, const MappingJob& job, const std::vector<double>& scales,
                const VisualOdometryConfig& config, VisualMap* map) {
  std::vector<std::int64_t> all;
  for (const auto& [id, landmark] : map->landmarks()) all.push_back(id);
  int n = fuse_landmarks(camera, all, job.newest, scales, config, map);
  const std::vector<std::int64_t> newest = landmarks_of(*map, job.newest);
  for (const std::int64_t other : job.moving)
    if (other != job.newest) n += fuse_landmarks(camera, newest, other, scales, config, map);
  return n;
}

}  // namespace

MappingJob make_mapping_job(const VisualMap& map, std::int64_t newest,
                            const VisualOdometryConfig& config) {
  MappingJob job;
  job.newest = newest;
  const MapKeyframe* centre = map.keyframe(newest);
  if (centre == nullptr) return job;
  std::set<std::int64_t> moving{newest};
  for (const auto& [id, shared] : covisible_keyframes(map, newest)) {
    if (static_cast<int>(moving.size()) >= config.bundle_keyframes) break;
    if (shared >= config.covisible_landmarks && map.keyframe(id)->segment == centre->segment)
      moving.insert(id);
  }
  job.moving.assign(moving.begin(), moving.end());

  // Who else sees their landmarks, most first: they hold.
  std::map<std::int64_t, int> others;
  for (const std::int64_t id : job.moving)
    for (const std::int64_t seen : map.keyframe(id)->landmark_of_feature)
      if (seen != 0)
        for (const Observation& o : map.landmark(seen)->observations)
          if (moving.count(o.keyframe) == 0) ++others[o.keyframe];
  std::vector<std::pair<int, std::int64_t>> ranked;
  ranked.reserve(others.size());
  for (const auto& [id, shared] : others) ranked.emplace_back(-shared, -id);
  std::sort(ranked.begin(), ranked.end());
  std::vector<std::int64_t> ids = job.moving;
  for (const auto& [shared, id] : ranked) {
    if (static_cast<int>(ids.size()) >= config.bundle_keyframes + config.bundle_fixed_keyframes)
      break;
    ids.push_back(-id);
  }
  std::sort(ids.begin(), ids.end());
  for (const std::int64_t id : ids)
    if (id > 1 && id + config.settle_keyframes < newest) job.cullable.push_back(id);
  job.part = map.copy_part(ids, job.moving);
  return job;
}

MappingResult improve_map(const CameraModel& camera, const MappingJob& job,
                          const std::vector<double>& scale_of_octave,
                          const VisualOdometryConfig& config) {
  MappingResult result;
  result.part = job.part;
  VisualMap* map = &result.part;
  result.n_triangulated = triangulate(camera, job.newest, job.moving, scale_of_octave, config, map);
  result.n_fused = fuse_around(camera, job, scale_of_octave, config, map);
  result.bundle = adjust_bundle(camera, job.moving, scale_of_octave, config, map);
  result.n_landmarks_culled = cull_landmarks(job.newest, config, map);
  result.n_keyframes_culled = cull_keyframes(job.cullable, config, map);
  return result;
}

void LocalMapping::start(MappingJob job) {
  job_ = std::move(job);
  result_ = std::async(std::launch::async,
                       [this] { return improve_map(camera_, job_, scales_, config_); });
}

MappingResult LocalMapping::finish(VisualMap* map) {
  MappingResult result = result_.get();
  map->put_back(job_.part, result.part);
  job_ = {};
  return result;
}

}  // namespace fusion_slam
