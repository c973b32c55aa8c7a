// Ground truth beside the estimate. Its frame is another than the map's, so it is moved onto the
// graph's nodes by least squares (Umeyama 1991), as `eval ape --align se3` does, each time the
// graph has changed. Items of Topic::kTruth: chunks of positions, and "alignment" with the motion
// and the error that remains. Not thread-safe.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "libs/geometry/timed_poses.hpp"
#include "viz/web/graph_view.hpp"
#include "viz/web/item_store.hpp"

namespace fusion_slam {

class TruthView {
 public:
  static constexpr std::size_t kChunkPoints = 256;
  static constexpr double kStep_m = 0.02;  // positions closer than this are not drawn

  explicit TruthView(ItemStore& store) : store_(store) {}

  void on_truth(std::int64_t utime_us, const SE3& T_truth_base);
  // Finds T_map_truth anew; costs time in proportion to the nodes.
  void align(const std::map<NodeId, GraphView::Node>& nodes);
  // Where the truth says the base is, in the map frame as far as that is known.
  std::optional<SE3> newest() const;
  void clear();

 private:
  std::optional<SE3> at(std::int64_t utime_us) const;  // interpolated over at most 1 s

  ItemStore& store_;
  TimedPoses poses_;
  std::vector<Eigen::Vector3f> drawn_;
  SE3 T_map_truth_ = SE3::Identity();
};

}  // namespace fusion_slam
