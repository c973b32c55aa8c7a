// What one tracker said over time: odometry-frame poses, each hanging on a graph node. Asked for a
// time between two poses, it interpolates; it never extrapolates and never bridges a break.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "libs/geometry/pose.hpp"
#include "libs/graph/node_id.hpp"
#include "libs/journal/note_bytes.hpp"

namespace fusion_slam {

struct TrackPose {
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  NodeId reference;  // id 0: none
  SE3 T_reference_base = SE3::Identity();
  Matrix6d covariance = Matrix6d::Identity();  // of T_reference_base
  std::int64_t fix_utime_us = 0;
  bool after_break =
      false;  // the track was lost just before: not continuous with the pose before it
};

struct TrackAnswer {
  TrackPose pose;           // at the time asked for
  std::int64_t gap_us = 0;  // between the two poses interpolated; 0: exactly one of them
};

class PoseTrack {
 public:
  PoseTrack(std::int64_t max_gap_us, std::int64_t memory_us)
      : max_gap_us_(max_gap_us), memory_us_(memory_us) {}

  void add(const TrackPose& pose);
  void mark_break() {
    broken_ = true;
  }  // the tracker is lost: the next pose doesn't continue this one

  std::optional<TrackAnswer> at(std::int64_t utime_us) const;
  // The newest pose not after a time that fits; nullptr: none.
  const TrackPose* newest_until(std::int64_t utime_us,
                                const std::function<bool(const TrackPose&)>& fits) const;
  void forget_from(std::int64_t utime_us);    // these times come a second time
  bool reaches(std::int64_t utime_us) const;  // a pose at or after that time has come
  // Motion between two times, when both can be answered and the track is unbroken from one to the
  // other.
  std::optional<SE3> motion(std::int64_t from_us, std::int64_t to_us) const;

  void write(NoteWriter* out) const;  // for the journal
  void read(NoteReader* in);          // all of it; whether it was good, `in` says

 private:
  std::int64_t max_gap_us_;
  std::int64_t memory_us_;
  bool broken_ = false;
  std::map<std::int64_t, TrackPose> poses_;
};

}  // namespace fusion_slam
