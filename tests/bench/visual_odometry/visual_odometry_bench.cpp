// Runs visual odometry and loop detection on a 7-Scenes or TUM RGB-D directory without any bus:
// trajectory, states, and time per frame on one core. Not a test: figures for people.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "libs/datasets/rgbd_dataset.hpp"
#include "services/loop_detector/loop_detector.hpp"
#include "services/visual_odometry/visual_odometry.hpp"

namespace fs = fusion_slam;

namespace {

void write_pose(std::ofstream& file, std::int64_t utime_us, const fs::SE3& T) {
  const Eigen::Quaterniond q(T.linear());
  char line[256];
  std::snprintf(line, sizeof line, "%.6f %.9f %.9f %.9f %.9f %.9f %.9f %.9f\n", utime_us * 1e-6,
                T.translation().x(), T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(),
                q.w());
  file << line;
}

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * (values.size() - 1))];
}

// Of this process's own work: other programs on the machine don't count.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// T_world_camera of the reference at this time; nothing when it has no pose within 20 ms.
const fs::SE3* reference_at(const fs::RgbdDataset& dataset, std::int64_t utime_us) {
  const fs::ReferencePose* best = nullptr;
  for (const fs::ReferencePose& pose : dataset.reference)
    if (best == nullptr || std::abs(pose.utime_us - utime_us) < std::abs(best->utime_us - utime_us))
      best = &pose;
  const bool near = best != nullptr && std::abs(best->utime_us - utime_us) < 20'000;
  return near ? &best->T_world_reference : nullptr;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Visual odometry on a directory of RGB-D images"};
  std::string directory;
  std::string out = "estimate.tum";
  std::string reference;
  bool tum = false;
  bool verbose = false;
  std::size_t every = 1;
  app.add_option("directory", directory)->required();
  app.add_option("--out", out, "trajectory of the camera, TUM format");
  app.add_option("--reference", reference, "also write the reference, TUM format");
  app.add_flag("--tum", tum, "TUM RGB-D instead of 7-Scenes");
  app.add_flag("--verbose", verbose, "a line for each keyframe, loss and loop candidate");
  app.add_option("--every", every, "use each n-th frame only");
  fs::VisualOdometryConfig config;
  app.add_option("--features", config.orb.n_features, "features of an image");
  app.add_option("--local-map", config.local_map_keyframes, "keyframes of the local map");
  app.add_option("--pixel-sigma", config.pixel_sigma, "noise of a corner, px");
  app.add_option("--radius", config.wide_radius_px, "first search around the prediction, px");
  app.add_option("--inlier-ratio", config.keyframe_inlier_ratio, "a keyframe below this");
  app.add_option("--parallax", config.keyframe_parallax, "a keyframe above this");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);
  const fs::RgbdDataset dataset =
      tum ? fs::open_tum_rgbd(directory) : fs::open_seven_scenes(directory);
  if (!reference.empty()) {
    std::ofstream file(reference);
    for (const auto& pose : dataset.reference)
      write_pose(file, pose.utime_us, pose.T_world_reference);
  }
  fs::VisualOdometry odometry(dataset.camera, fs::SE3::Identity(), config);
  fs::LoopDetector detector(dataset.camera, fs::SE3::Identity());
  std::ofstream file(out);
  std::vector<double> odometry_ms;
  std::vector<double> detector_ms;
  std::vector<double> matched;
  std::vector<double> loop_errors_m;  // of those that passed geometry
  std::map<std::int64_t, std::int64_t> utime_of_keyframe;
  int states[4] = {};
  int keyframes = 0;
  int candidates = 0;
  int geometric = 0;
  for (std::size_t i = 0; i < dataset.entries.size(); i += every) {
    std::string why;
    const auto frame = fs::load_frame(dataset, i, &why);
    if (!frame) {
      std::printf("frame %zu: %s\n", i, why.c_str());
      continue;
    }
    double start_ms = cpu_ms();
    const fs::TrackingResult result = odometry.track(*frame);
    odometry_ms.push_back(cpu_ms() - start_ms);
    matched.push_back(result.n_matched);
    ++states[static_cast<int>(result.state)];
    const bool usable =
        result.state == fs::TrackingState::kOk || result.state == fs::TrackingState::kWeak;
    if (usable) write_pose(file, result.utime_us, result.T_odom_base);
    if (verbose && result.state != fs::TrackingState::kOk)
      std::printf("frame %zu: state %d, %s\n", i, static_cast<int>(result.state),
                  result.reason.c_str());
    if (!result.keyframe) continue;
    ++keyframes;
    const fs::Keyframe& k = *result.keyframe;
    utime_of_keyframe[k.id] = k.utime_us;
    if (verbose)
      std::printf("frame %zu: keyframe %lld, %d matched, %zu features\n", i,
                  static_cast<long long>(k.id), result.n_matched, k.features.size());
    start_ms = cpu_ms();
    const auto found = detector.add({k.id, k.utime_us, k.T_odom_base, k.features});
    detector_ms.push_back(cpu_ms() - start_ms);
    for (const fs::LoopCandidate& c : found) {
      ++candidates;
      geometric += c.stages[1].passed ? 1 : 0;
      const fs::SE3* from = reference_at(dataset, utime_of_keyframe[c.from_id]);
      const fs::SE3* to = reference_at(dataset, k.utime_us);
      if (c.stages[1].passed && from != nullptr && to != nullptr)
        loop_errors_m.push_back(fs::local(from->inverse() * *to, c.T_from_to).head<3>().norm());
      if (!verbose) continue;
      std::printf("  %lld -> %lld:", static_cast<long long>(c.to_id),
                  static_cast<long long>(c.from_id));
      for (const fs::StageVerdict& s : c.stages)
        std::printf(" %s %.3f/%.3f %s;", s.stage.c_str(), s.score, s.threshold,
                    s.passed ? "yes" : "no");
      std::printf("\n");
    }
  }
  std::printf("%zu frames: ok %d weak %d lost %d refused %d; %d keyframes, median %.0f matched\n",
              odometry_ms.size(), states[1], states[2], states[3], states[0], keyframes,
              quantile(matched, 0.5));
  std::printf("odometry CPU ms a frame: median %.1f p95 %.1f max %.1f\n",
              quantile(odometry_ms, 0.5), quantile(odometry_ms, 0.95), quantile(odometry_ms, 1.0));
  std::printf(
      "loop detector: %d candidates, %d geometric; CPU ms a keyframe: median %.1f max %.1f\n",
      candidates, geometric, quantile(detector_ms, 0.5), quantile(detector_ms, 1.0));
  std::printf("loops that passed geometry, m from the reference: median %.3f p95 %.3f max %.3f\n",
              quantile(loop_errors_m, 0.5), quantile(loop_errors_m, 0.95),
              quantile(loop_errors_m, 1.0));
  return 0;
}
