// Runs visual odometry on a recording without any bus: accuracy, states, and time per frame. Not a
// test: figures for people.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <map>
#include <memory>
#include <numeric>
#include <thread>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sys/resource.h>

#include "libs/evaluation/trajectory_error.hpp"
#include "libs/evaluation/tum_file.hpp"
#include "services/visual_odometry/visual_odometry.hpp"
#include "tests/bench/visual_odometry/keyframe_picture.hpp"
#include "tests/bench/visual_odometry/lidar_predictor.hpp"
#include "tests/bench/visual_odometry/lost_spells.hpp"
#include "tests/bench/visual_odometry/recording_source.hpp"
#include "tests/bench/visual_odometry/standing.hpp"

namespace fusion_slam {
namespace {

struct Posed {
  std::int64_t utime_us = 0;
  SE3 T_odom_base = SE3::Identity();
  std::int64_t reference = 0;
  SE3 T_reference_base = SE3::Identity();
};

struct Edge {
  std::int64_t previous = 0;
  SE3 T_previous_base = SE3::Identity();
  SE3 T_odom_base = SE3::Identity();  // used when there is no previous one
};

struct Run {
  CameraModel camera;
  RobotModel robot;
  std::unique_ptr<VisualOdometry> odometry;
  std::vector<Posed> poses;
  std::map<std::int64_t, Edge> edges;
  std::vector<double> cpu_ms;   // of the tracking thread
  std::vector<double> wall_ms;  // as a caller waits
  std::vector<double> wait_ms;  // wall without CPU, of frames that waited for local mapping
  int states[4] = {};
  int keyframes = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  std::string picture;  // file; empty: none
  std::int64_t picture_of = 0;
  Keyframe last_keyframe;
  RgbdFrame last_frame;
  LostSpells lost;
  std::unique_ptr<LidarPredictor> predictor;  // null: no LIDAR_POSE, or from a log
  std::int64_t newest_landmark = 0;           // before this keyframe
};

void remember(const RgbdFrame& frame, const Keyframe& keyframe, Run* run) {
  if (!run->picture.empty() && keyframe.id == run->picture_of)
    cv::imwrite(run->picture, draw_keyframe(frame.colour_bgr, keyframe, run->last_keyframe,
                                            run->newest_landmark));
  run->last_keyframe = keyframe;
  for (const std::int64_t id : keyframe.landmark_of_feature)
    run->newest_landmark = std::max(run->newest_landmark, id);
}

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * (values.size() - 1))];
}

double thread_cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec * 1e3 + now.tv_nsec * 1e-6;
}

void track(const RgbdFrame& frame, bool verbose, Run* run) {
  const auto wall = std::chrono::steady_clock::now();
  const double cpu = thread_cpu_ms();
  const int waits = run->odometry->counts().mapping_waits;
  const int revised = run->odometry->counts().revised_keyframes;
  const TrackingResult result = run->odometry->track(frame);
  run->cpu_ms.push_back(thread_cpu_ms() - cpu);
  run->wall_ms.push_back(
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - wall).count());
  if (run->odometry->counts().mapping_waits > waits)
    run->wait_ms.push_back(run->wall_ms.back() - run->cpu_ms.back());
  if (run->first_us == 0) run->first_us = frame.utime_us;
  run->last_frame = frame;
  run->lost.on(result, run->odometry->counts());
  if (run->predictor) run->predictor->add_visual(result);
  run->last_us = frame.utime_us;
  ++run->states[static_cast<int>(result.state)];
  const bool usable = result.state == TrackingState::kOk || result.state == TrackingState::kWeak;
  if (usable)
    run->poses.push_back(
        {result.utime_us, result.T_odom_base, result.reference_id, result.T_reference_base});
  if (verbose)
    std::printf("%.3f s: state %d, %d matched, keyframe %lld %s%s\n",
                (frame.utime_us - run->first_us) * 1e-6, static_cast<int>(result.state),
                result.n_matched, static_cast<long long>(result.reference_id),
                result.keyframe ? "NEW " : "", result.reason.c_str());
  if (verbose && run->odometry->counts().revised_keyframes > revised)
    std::printf("%d keyframes moved by the graph\n",
                run->odometry->counts().revised_keyframes - revised);
  if (!result.keyframe) return;
  ++run->keyframes;
  const Keyframe& k = *result.keyframe;
  remember(frame, k, run);
  run->edges[k.id] = {k.previous_id, k.T_previous_base, k.T_odom_base};
  for (const RefinedEdge& edge : k.refined)
    run->edges[edge.id].T_previous_base = edge.T_previous_base;
}

// The trajectory as a user gets it in the end, without loop closures: edges as local mapping left
// them.
Trajectory final_trajectory(const Run& run) {
  std::map<std::int64_t, SE3> T_odom_keyframe;
  for (const auto& [id, edge] : run.edges) {
    const auto previous = T_odom_keyframe.find(edge.previous);
    T_odom_keyframe[id] = previous == T_odom_keyframe.end()
                              ? edge.T_odom_base
                              : previous->second * edge.T_previous_base;
  }
  Trajectory result;
  for (const Posed& p : run.poses)
    result.push_back({p.utime_us * 1e-6, T_odom_keyframe[p.reference] * p.T_reference_base *
                                             run.robot.T_base_reference()});
  return result;
}

Trajectory live_trajectory(const Run& run) {
  Trajectory result;
  for (const Posed& p : run.poses)
    result.push_back({p.utime_us * 1e-6, p.T_odom_base * run.robot.T_base_reference()});
  return result;
}

double rpe(const Trajectory& reference, const Trajectory& estimate, ErrorRelation relation,
           const RelativeOptions& relative) {
  EvaluationOptions options;
  options.alignment = Alignment::kSe3;
  options.relation = relation;
  const auto error = evaluate_rpe(reference, estimate, options, relative);
  return error ? error->statistics.rmse : -1.0;
}

struct Scores {
  double ape_m = -1.0, ape_max_m = -1.0, frame_m = -1.0, metre_m = -1.0, metre_deg = -1.0;
  double coverage = 0.0;
};

Scores score(const Run& run, const Trajectory& reference, const Trajectory& estimate) {
  Scores s;
  EvaluationOptions options;
  options.alignment = Alignment::kSe3;
  options.window = TimeWindow{run.first_us * 1e-6, run.last_us * 1e-6};
  const auto ape = evaluate_ape(reference, estimate, options);
  if (!ape) {
    std::printf("no APE: %s\n", ape.problem.c_str());
    return s;
  }
  s.ape_m = ape->statistics.rmse;
  s.ape_max_m = ape->statistics.max;
  s.coverage = ape->coverage.percent;
  const RelativeOptions metre{1.0, DeltaUnit::kMeters, true};
  s.frame_m = rpe(reference, estimate, ErrorRelation::kTranslation, {});
  s.metre_m = rpe(reference, estimate, ErrorRelation::kTranslation, metre);
  s.metre_deg = rpe(reference, estimate, ErrorRelation::kRotation, metre);
  return s;
}

void print(const Run& run, const std::string& name, const Scores& live, const Scores& last) {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const VisualOdometryCounts& c = run.odometry->counts();
  std::printf(
      "%zu frames: ok %d weak %d lost %d refused %d; %d keyframes, %zu kept, %zu landmarks\n",
      run.cpu_ms.size(), run.states[1], run.states[2], run.states[3], run.states[0], run.keyframes,
      run.odometry->map().keyframes().size(), run.odometry->map().landmarks().size());
  std::printf(
      "mapping: %d jobs, %d triangulated, %d fused, %d observations refused, %d landmarks "
      "and %d keyframes culled; %d relocalisations, %d joins, %lld LiDAR depths, %lld LiDAR "
      "guesses, %d frames carried by surfaces, %d keyframes moved by the graph\n",
      c.mappings, c.triangulated, c.fused, c.observations_refused, c.landmarks_culled,
      c.keyframes_culled, c.relocalisations, c.joins, static_cast<long long>(c.lidar_depths),
      static_cast<long long>(c.lidar_guesses), c.carried_frames, c.revised_keyframes);
  const double mean_ms = std::accumulate(run.cpu_ms.begin(), run.cpu_ms.end(), 0.0) /
                         static_cast<double>(std::max<std::size_t>(1, run.cpu_ms.size()));
  std::printf(
      "CPU ms a frame (tracking thread): mean %.1f median %.1f p95 %.1f p99 %.1f max %.1f\n",
      mean_ms, quantile(run.cpu_ms, 0.5), quantile(run.cpu_ms, 0.95), quantile(run.cpu_ms, 0.99),
      quantile(run.cpu_ms, 1.0));
  std::printf(
      "waits for local mapping: %zu of %d results; ms: median %.1f p95 %.1f max %.1f; %d keyframes "
      "came while it was at work\n",
      run.wait_ms.size(), c.mappings, quantile(run.wait_ms, 0.5), quantile(run.wait_ms, 0.95),
      quantile(run.wait_ms, 1.0), c.mappings_late);
  std::printf("live poses: APE %.4f (max %.4f), RPE/frame %.4f, RPE/m %.4f m %.3f deg\n",
              live.ape_m, live.ape_max_m, live.frame_m, live.metre_m, live.metre_deg);
  std::printf(
      "| %s | %.1f %% | %.4f (%.4f) | %.4f | %.4f, %.3f | %.1f / %.1f / %.1f | %.1f / %.1f | %ld "
      "|\n",
      name.c_str(), last.coverage, last.ape_m, last.ape_max_m, last.frame_m, last.metre_m,
      last.metre_deg, quantile(run.cpu_ms, 0.5), quantile(run.cpu_ms, 0.95),
      quantile(run.cpu_ms, 0.99), quantile(run.wall_ms, 0.5), quantile(run.wall_ms, 0.99),
      usage.ru_maxrss / 1024);
}

// After the recording the camera stands where it is.
void stand(double minutes, double hz, Run* run) {
  const VisualMap& map = run->odometry->map();
  const SE3 T_before = run->poses.empty() ? SE3::Identity() : run->poses.back().T_odom_base;
  const auto tell = [&](int minute) {
    if (minute % 5 != 0 && minute != 1) return;
    const SE3 T_moved = T_before.inverse() * run->poses.back().T_odom_base;
    std::printf(
        "standing %2d min: %zu keyframes, %zu landmarks, %.1f MB resident, pose %.1f mm off\n",
        minute, map.keyframes().size(), map.landmarks().size(), resident_mb(),
        1e3 * T_moved.translation().norm());
  };
  const RgbdFrame frame = run->last_frame;
  const int before = run->keyframes;
  tell(0);
  stand_still(
      frame, run->camera, minutes, hz, [&](const RgbdFrame& again) { track(again, false, run); },
      tell);
  std::printf("standing: %d keyframes made\n", run->keyframes - before);
}

int bench(int argc, char** argv) {
  CLI::App app{"Visual odometry on a recording: a directory of RGB-D images or an LCM log"};
  std::string path, out, live_out, reference_out, lidar_poses, graph, name;
  bool verbose = false;
  bool paced = false;
  bool lidar_mapper = false;
  double stand_minutes = 0.0;
  double stand_hz = 2.5;
  VisualOdometryConfig config;
  Run run;
  app.add_option("recording", path)->required();
  app.add_option("--out", out, "trajectory in the end, TUM format");
  app.add_option("--live", live_out, "poses as they were said, TUM format");
  app.add_option("--reference", reference_out, "also write the reference, TUM format");
  app.add_option("--lidar-poses", lidar_poses, "a log with LIDAR_POSE of the same drive");
  app.add_option("--graph", graph, "a log with GRAPH of the same drive, which is followed");
  app.add_flag("--lidar-mapper", lidar_mapper, "LIDAR_POSE by the LiDAR mapper, beside");
  app.add_option("--stand", stand_minutes, "then stand still for so many minutes of stamps");
  app.add_option("--stand-hz", stand_hz, "frames a second while standing");
  app.add_option("--name", name, "of the table's row");
  app.add_flag("--verbose", verbose, "a line for each keyframe and each frame that is not OK");
  app.add_option("--picture", run.picture, "a keyframe with its features and matches");
  app.add_option("--picture-of", run.picture_of, "which keyframe");
  app.add_flag("--paced", paced, "at the camera's own rate");
  app.add_flag("!--no-wait", config.wait_for_mapping,
               "as on a robot: local mapping's result is taken when it is there");
  app.add_flag("!--no-lidar-depth", config.use_lidar_depth);
  app.add_flag("!--no-lidar-motion", config.use_lidar_motion);
  app.add_flag("!--no-surfaces", config.use_surfaces);
  app.add_flag("!--no-planar", config.use_planar);
  app.add_option("--fast-low", config.orb.fast_threshold_low);
  app.add_flag("--sub-pixel", config.orb.sub_pixel);
  app.add_option("--features", config.orb.n_features);
  app.add_option("--pixel-sigma", config.pixel_sigma);
  app.add_option("--bundle", config.bundle_keyframes);
  app.add_option("--bundle-fixed", config.bundle_fixed_keyframes);
  app.add_option("--near", config.local_near_keyframes);
  app.add_option("--covisible", config.local_covisible_keyframes);
  app.add_option("--recent", config.local_recent_keyframes);
  app.add_option("--parallax", config.keyframe_parallax);
  app.add_option("--rotation", config.keyframe_rotation_rad);
  app.add_option("--iterations", config.bundle_iterations);
  app.add_option("--fuse-radius", config.fuse_radius_px);
  app.add_option("--parallax-rad", config.min_parallax_rad);
  app.add_option("--redundant", config.redundant_share);
  app.add_option("--trial-keyframes", config.trial_keyframes);
  app.add_option("--trial-frames", config.trial_frames);
  app.add_option("--outlier", config.bundle_outlier_3d);
  app.add_option("--mapping-frames", config.mapping_frames);
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);

  BenchListener listener;
  listener.models = [&](const CameraModel& camera, const RobotModel& robot) {
    run.camera = camera;
    run.robot = robot;
    run.odometry = std::make_unique<VisualOdometry>(camera, robot, config);
    if (lidar_mapper) run.predictor = std::make_unique<LidarPredictor>(robot);
  };
  const auto start = std::chrono::steady_clock::now();
  listener.frame = [&](const RgbdFrame& frame) {
    if (paced && run.first_us != 0)
      std::this_thread::sleep_until(start +
                                    std::chrono::microseconds(frame.utime_us - run.first_us));
    track(frame, verbose, &run);
  };
  listener.scan = [&](const LaserScan& scan) {
    run.odometry->add_scan(scan);
    if (run.predictor)
      run.predictor->add_scan(scan, [&](std::int64_t utime_us, const SE3& T) {
        run.odometry->add_lidar_pose(utime_us, T);
      });
  };
  listener.odometry = [&](std::int64_t utime_us, const SE3& T) {
    if (run.predictor) run.predictor->add_odometry(utime_us, T);
  };
  listener.lidar_pose = [&](std::int64_t utime_us, const SE3& T) {
    run.odometry->add_lidar_pose(utime_us, T);
  };
  listener.graph_node = [&](std::int64_t keyframe, const SE3& T) {
    run.odometry->add_graph_node(keyframe, T);
  };
  const Trajectory reference = play_recording(path, lidar_poses, graph, listener);
  const Trajectory last = final_trajectory(run);
  if (!out.empty()) write_tum(out, last);
  if (!live_out.empty()) write_tum(live_out, live_trajectory(run));
  if (!reference_out.empty()) write_tum(reference_out, reference);
  print(run, name.empty() ? path : name, score(run, reference, live_trajectory(run)),
        score(run, reference, last));
  run.lost.print(run.first_us, reference);
  if (stand_minutes > 0.0) stand(stand_minutes, stand_hz, &run);
  return 0;
}

}  // namespace
}  // namespace fusion_slam

int main(int argc, char** argv) {
  try {
    return fusion_slam::bench(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "visual_odometry_bench: %s\n", e.what());
    return 1;
  }
}
