// How good are the poses of visual closures? Each pair of keyframes of a simulated session that
// look alike is measured as the loop detector does it, and one line says how far that is from the
// truth and what the measurement itself says of its quality.
//   visual_closure_bench SESSION.lcmlog
// Columns: the two keyframes, error (m, degrees), sigma that the measurement claims (worst
// direction in m, and degrees; before any factor), error squared in units of that covariance (6
// degrees of freedom), matches, inliers, apart (m and degrees: true distance of the two views).
#include <cmath>
#include <cstdio>
#include <map>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "bot_core/pose_t.hpp"
#include "fusion_slam/keyframe_t.hpp"
#include "libs/eventlog/reader.hpp"
#include "libs/messages/convert.hpp"
#include "libs/messages/models.hpp"
#include "libs/places/geometry_check.hpp"
#include "libs/places/place_index.hpp"
#include "services/loop_detector/config.hpp"
#include "services/loop_detector/loop_messages.hpp"
#include "services/loop_detector/loop_types.hpp"
#include "tests/bench/loops/edge_nees.hpp"

int main(int argc, char** argv) {
  using namespace fusion_slam;
  if (argc != 2) return std::fprintf(stderr, "visual_closure_bench SESSION.lcmlog\n"), 2;
  LogReader reader(argv[1]);
  LogEvent event;
  std::string why;
  std::optional<RobotModel> robot;
  std::optional<CameraModel> camera;
  TruePoses truth;
  std::map<std::int64_t, LoopKeyframe> keyframes;
  while (reader.next(&event)) {
    const auto read = [&](auto message) {
      message.decode(event.data.data(), 0, static_cast<int>(event.data.size()));
      return message;
    };
    if (event.channel == "ROBOT_MODEL" && !robot) {
      robot = from_message(read(robot_model_t{}), &why);
    } else if (event.channel == "CAMERA_MODEL" && !camera) {
      camera = from_message(read(camera_model_t{}), &why);
    } else if (event.channel == "GROUND_TRUTH") {
      const auto m = read(bot_core::pose_t{});
      if (const auto T = from_message(m)) truth[m.utime] = *T;
    } else if (event.channel == "KEYFRAME") {
      if (auto k = from_message(read(keyframe_t{}), &why)) keyframes[k->id] = std::move(*k);
    }
  }
  if (!robot || !camera) return std::fprintf(stderr, "no camera in it\n"), 1;
  const LoopDetectorConfig config;
  PlaceIndex places(config.appearance);
  for (const auto& [id, newer] : keyframes) {
    places.add(id, newer.utime_us, newer.features);
    for (const PlaceIndex::Place& place : places.like(newer.features)) {
      const LoopKeyframe& older = keyframes.at(place.id);
      const GeometryCheck check =
          check_geometry(*camera, older.features, newer.features, config.geometry);
      const auto a = true_pose(truth, older.utime_us), b = true_pose(truth, newer.utime_us);
      if (check.n_inliers < config.geometry.min_inliers || !a || !b) continue;
      const SE3 T_reference_camera = robot->T_base_reference().inverse() * robot->T_base_camera;
      const SE3 right = (*a * T_reference_camera).inverse() * *b * T_reference_camera;
      const Vector6d e = local(right, check.T_older_newer);
      const auto worst = [&](int at) {
        const Eigen::Matrix3d block = check.covariance.block<3, 3>(at, at);
        return std::sqrt(
            Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(block).eigenvalues().maxCoeff());
      };
      std::printf(
          "%ld %ld error %.4f m %.3f deg sigma %.4f m %.3f deg chi2 %.1f matches %d inliers %d "
          "apart %.2f m %.1f deg\n",
          static_cast<long>(place.id), static_cast<long>(id), e.head<3>().norm(),
          e.tail<3>().norm() * 180.0 / M_PI, worst(0), worst(3) * 180.0 / M_PI,
          e.dot(check.covariance.ldlt().solve(e)), check.n_matches, check.n_inliers,
          right.translation().norm(), log_so3(right.linear()).norm() * 180.0 / M_PI);
    }
  }
  return 0;
}
