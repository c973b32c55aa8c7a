// What visual odometry knows of the world: keyframes, and the landmarks that they see. A plain
// value: a part of it can be copied, improved elsewhere and put back. Poses and points are in odom.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "libs/features/feature.hpp"
#include "libs/geometry/pose.hpp"
#include "services/visual_odometry/landmark_table.hpp"

namespace fusion_slam {

struct Observation {
  std::int64_t keyframe = 0;
  int feature = 0;  // index into the keyframe's features
};

struct Landmark {
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of p_odom, 1/m^2
  Eigen::Vector3d viewed_from = Eigen::Vector3d::Zero();  // unit, to the camera that saw it last
  Descriptor descriptor{};                                // of that view
  float angle_rad = 0.0F;                                 // of that view
  double reach_m = 0.0;  // distance * scale: what would be seen at octave 0 at this distance
  std::vector<Observation> observations;  // ascending in keyframe, one each at most
  std::int64_t born = 0;                  // newest keyframe when it was made
  int visible = 0;                        // frames in which it should have been seen
  int found = 0;                          // and was
};

// What surfaces say of the motion between two keyframes where few features do.
struct SurfaceTie {
  std::int64_t keyframe = 0;                // the earlier one; 0: no tie
  SE3 T_earlier_camera = SE3::Identity();   // of the camera of the later one
  Matrix6d information = Matrix6d::Zero();  // of xi in retract(), camera axes; may be singular
};

struct MapKeyframe {
  std::int64_t id = 0;
  std::int64_t utime_us = 0;
  int segment = 0;  // keyframes of different segments have no known motion between them
  SE3 T_odom_camera = SE3::Identity();
  std::shared_ptr<const FeatureSet> features;
  std::vector<std::int64_t> landmark_of_feature;  // 0: none
  SurfaceTie tie;
  std::int64_t previous = 0;  // keyframe that it was tracked from; 0: none
};

// Every link is known at both ends: a landmark's observation and the keyframe's feature. A part
// (copy_part) may lack keyframes that its landmarks name; they are left alone. Not thread-safe.
class VisualMap {
 public:
  using Keyframes = std::map<std::int64_t, MapKeyframe>;
  using Landmarks = LandmarkTable<Landmark>;

  const Keyframes& keyframes() const { return keyframes_; }
  const Landmarks& landmarks() const { return landmarks_; }
  const MapKeyframe* keyframe(std::int64_t id) const;  // null: no such
  MapKeyframe* keyframe(std::int64_t id);
  const Landmark* landmark(std::int64_t id) const;
  Landmark* landmark(std::int64_t id);

  // `keyframe.landmark_of_feature` has one entry a feature, all 0.
  void add_keyframe(MapKeyframe keyframe);
  void erase_keyframe(std::int64_t id);  // landmarks that nobody else sees go with it

  std::int64_t add_landmark(Landmark landmark);  // without observations; returns its id, above 0
  void erase_landmark(std::int64_t id);
  // Both ends. False, and nothing happens, when the keyframe sees this landmark already, the
  // feature shows another one, or either does not exist.
  bool link(std::int64_t landmark, std::int64_t keyframe, int feature);
  // Both ends; a landmark without observations is erased.
  void unlink(std::int64_t landmark, std::int64_t keyframe);
  // All that `from` was seen as becomes `to`, where no keyframe would see `to` twice; `from` goes.
  void merge(std::int64_t from, std::int64_t to);

  // Landmarks follow keyframes whose poses have just been moved by T_new_old, in odom. A landmark
  // goes, or stays, with the newest keyframe that sees it: what is seen now stays with what is now.
  // Keyframes for which it would then lie elsewhere keep a copy, where they saw it, so that neither
  // side loses anything and no observation holds the two together. Returns the copies' ids.
  std::vector<std::int64_t> carry_landmarks(
      const std::map<std::int64_t, SE3>& T_new_old_of_keyframe);

  // Surfaces no longer tie keyframes of which one has been moved and the other not.
  void untie(const std::map<std::int64_t, SE3>& moved);

  // Keyframes and landmarks of segment `from` become part of segment `to`; T_to_from moves them.
  // Returns as carry_landmarks().
  std::vector<std::int64_t> join_segment(int from, int to, const SE3& T_to_from);

  // The keyframes of `ids` and every landmark that those of `seen_by` see. New landmarks of the
  // part get ids that this map has not given yet.
  VisualMap copy_part(const std::vector<std::int64_t>& ids,
                      const std::vector<std::int64_t>& seen_by) const;
  // Puts an improved part back: `before` is the part as it was copied. What of it was erased is
  // erased here, what was merged is merged here too, counts (visible, found) made since are kept.
  // Keyframes that came since the copy keep what they see and go where the
  // keyframe goes that they hang on (`previous`), their own landmarks with them. No other keyframe
  // may have been moved or erased here since the copy.
  void put_back(const VisualMap& before, const VisualMap& after);

  // Pairs (from, to) of merge(), in order, since this value was copied.
  const std::vector<std::pair<std::int64_t, std::int64_t>>& merged() const { return merged_; }

 private:
  Keyframes keyframes_;
  Landmarks landmarks_;
  std::int64_t next_landmark_ = 1;
  std::int64_t newest_at_copy_ = 0;  // of a part: the newest keyframe that the whole had then
  // Of the observers of one landmark, those that don't go with the newest get a copy.
  void carry_landmark(std::int64_t id, const std::map<std::int64_t, SE3>& T_new_old_of_keyframe,
                      std::vector<std::int64_t>* copies);
  void move_newer(const VisualMap& before, const VisualMap& after);
  std::vector<std::pair<std::int64_t, std::int64_t>> merged_;
};

// Renews what a landmark looks like: seen last as this feature from there.
void renew_look(const FeatureSet& set, int feature, const SE3& T_odom_camera, double scale,
                Landmark* landmark);

}  // namespace fusion_slam
