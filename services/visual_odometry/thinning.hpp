// Keyframes of long ago go where others show the same: the map grows with the area, not with time.
#pragma once

#include <cstdint>
#include <set>

#include "services/visual_odometry/config.hpp"
#include "services/visual_odometry/visual_map.hpp"

namespace fusion_slam {

// A keyframe becomes old config.thin_age_us after it was taken. Of the old ones that show one place
// (thin_m, thin_cosine, the same segment) those stay that came first, thin_older of them, and the
// thin_newer that came last; what lies between goes. As the views of a place in the loop detector:
// the oldest hold the map together, the newest look as it looks now. Those that came first stay
// for good (unless local mapping culls them), so that no place is lost by and by.
class KeyframeThinning {
 public:
  // Looks at the keyframes that have become old since the last call. `reference` stays. Returns how
  // many went.
  int thin(std::int64_t reference, const VisualOdometryConfig& config, VisualMap* map);

 private:
  bool spare(const MapKeyframe& keyframe, const VisualOdometryConfig& config,
             const VisualMap& map) const;

  std::int64_t last_old_ = 0;     // keyframe
  std::set<std::int64_t> first_;  // those that came first to their place
};

}  // namespace fusion_slam
