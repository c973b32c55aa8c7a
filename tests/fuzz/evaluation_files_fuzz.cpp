// link: fs_evaluation
// TUM trajectories and relations files: refused with a FileError, or read to finite poses in order
// of time that are the same when written and read again.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>

#include "libs/evaluation/relations.hpp"
#include "libs/evaluation/tum_file.hpp"

namespace {

void require(bool ok) {
  if (!ok) std::abort();
}

bool close(double a, double b) { return std::abs(a - b) <= 1e-6 + 1e-15 * std::abs(a); }

void try_tum(const std::string& text, fusion_slam::Trajectory* trajectory) {
  std::istringstream in(text);
  try {
    *trajectory = fusion_slam::read_tum(in, "fuzz").trajectory;
  } catch (const fusion_slam::FileError&) {
    return;
  }
  require(!trajectory->empty());
  std::stringstream written;
  fusion_slam::write_tum(written, *trajectory, "fuzz");
  const auto again = fusion_slam::read_tum(written, "written");
  require(again.out_of_order == 0 && again.trajectory.size() == trajectory->size());
  for (std::size_t i = 0; i < trajectory->size(); ++i) {
    const auto& pose = (*trajectory)[i];
    const auto& back = again.trajectory[i];
    require(i == 0 || (*trajectory)[i - 1].time_s <= pose.time_s);
    require(pose.T_world_body.matrix().allFinite() && close(pose.time_s, back.time_s));
    for (int axis = 0; axis < 3; ++axis)
      require(close(pose.T_world_body.translation()[axis], back.T_world_body.translation()[axis]));
    require((pose.T_world_body.linear() - back.T_world_body.linear()).norm() < 1e-6);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  fusion_slam::Trajectory trajectory;
  try_tum(text, &trajectory);
  std::istringstream in(text);
  try {
    const auto relations = fusion_slam::read_relations(in, "fuzz");
    require(!relations.empty());
    for (const auto& relation : relations) require(relation.T_1_2.matrix().allFinite());
    fusion_slam::evaluate_relations(relations, trajectory, {});
    fusion_slam::RelationsOptions options;
    options.nearest = true;
    fusion_slam::evaluate_relations(relations, trajectory, options);
  } catch (const fusion_slam::FileError&) {
  }
  return 0;
}
