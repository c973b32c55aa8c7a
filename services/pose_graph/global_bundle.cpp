#include "services/pose_graph/global_bundle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "services/pose_graph/landmark_part.hpp"
#include "services/pose_graph/sparse_problem.hpp"

namespace fusion_slam {
namespace {

NodeId keyframe(std::int64_t id) { return {NodeKind::kKeyframe, id}; }

bool between_keyframes(const GraphEdge& edge) {
  return edge.from.kind == NodeKind::kKeyframe && edge.to.kind == NodeKind::kKeyframe &&
         (edge.kind == EdgeKind::kVisual || edge.kind == EdgeKind::kLoop);
}

using SharedPoints = std::map<std::pair<NodeId, NodeId>, int>;

// How many points the two ends of each camera's edge share.
SharedPoints shared_points(const std::vector<Track>& tracks, const std::vector<GraphEdge>& edges) {
  SharedPoints shared;
  for (const GraphEdge& edge : edges)
    if (between_keyframes(edge)) shared[std::minmax(edge.from, edge.to)] = 0;
  for (const Track& track : tracks)
    for (std::size_t a = 0; a < track.size(); ++a)
      for (std::size_t b = a + 1; b < track.size(); ++b) {
        const auto found = shared.find({keyframe(track[a].keyframe), keyframe(track[b].keyframe)});
        if (found != shared.end()) ++found->second;
      }
  return shared;
}

// What the points say themselves need not be said by an edge made of them.
std::vector<GraphEdge> without_double_counting(const BundleConfig& config,
                                               const std::vector<Track>& tracks,
                                               const std::vector<GraphEdge>& edges) {
  const SharedPoints shared = shared_points(tracks, edges);
  std::vector<GraphEdge> kept = edges;
  for (GraphEdge& edge : kept) {
    edge.adjusted.reset();
    if (between_keyframes(edge) &&
        shared.at(std::minmax(edge.from, edge.to)) >= config.covered_points)
      edge.covariance *= config.covered_factor;
  }
  return kept;
}

double median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Where the sights with depth put the point: the median of each coordinate.
Eigen::Vector3d first_guess(const BundleQuestion& question, const GraphNodes& nodes,
                            const Track& track) {
  std::array<std::vector<double>, 3> at;
  for (const Sight& sight : track) {
    if (!(sight.seen.depth_m > 0.0F)) continue;
    const Eigen::Vector3d p =
        nodes.at(keyframe(sight.keyframe)).T_map_base * question.T_base_camera *
        question.camera.unproject(sight.seen.u_px, sight.seen.v_px, sight.seen.depth_m);
    for (int i = 0; i < 3; ++i) at[static_cast<std::size_t>(i)].push_back(p[i]);
  }
  return {median(&at[0]), median(&at[1]), median(&at[2])};
}

Correspondence observation(const BundleConfig& config, const CameraModel& camera,
                           const SeenFeature& seen) {
  Correspondence c;
  c.pixel = {seen.u_px, seen.v_px};
  c.pixel_sigma = config.pixel_sigma * std::pow(config.octave_scale, seen.octave);
  c.depth_m = seen.depth_m;
  c.depth_sigma_m =
      seen.depth_sigma_m > 0.0F ? seen.depth_sigma_m : camera.depth_sigma(seen.depth_m);
  return c;
}

// Tracks whose keyframes are in the graph.
std::vector<Track> known_tracks(const PoseGraphConfig& config, const BundleQuestion& question,
                                const GraphNodes& nodes) {
  std::vector<Track> tracks = question.seen.tracks(question.same, config.bundle.limits);
  for (Track& track : tracks)
    track.erase(
        std::remove_if(track.begin(), track.end(),
                       [&](const Sight& s) { return nodes.count(keyframe(s.keyframe)) == 0; }),
        track.end());
  const auto useless = [](const Track& track) {
    return track.size() < 2 || std::none_of(track.begin(), track.end(),
                                            [](const Sight& s) { return s.seen.depth_m > 0.0F; });
  };
  tracks.erase(std::remove_if(tracks.begin(), tracks.end(), useless), tracks.end());
  return tracks;
}

// The worst of the edges that agreed before and don't any more, when there are too many of a kind;
// nothing: the result agrees with what was measured.
std::string contradiction(const PoseGraphConfig& config, bool planar, const GraphNodes& before,
                          const GraphNodes& after, const std::vector<GraphEdge>& edges) {
  struct Kind {
    int edges = 0;
    int contradicted = 0;
    double worst = 0.0;
    GraphEdge edge;
  };
  std::map<EdgeKind, Kind> kinds;
  for (GraphEdge edge : edges) {
    Kind& kind = kinds[edge.kind];
    ++kind.edges;
    edge.adjusted.reset();
    const double error = edge_error(config, planar, after, edge);
    if (error <= config.bundle.gate_chi2 ||
        edge_error(config, planar, before, edge) > config.bundle.gate_chi2)
      continue;
    ++kind.contradicted;
    if (error <= kind.worst) continue;
    kind.worst = error;
    kind.edge = edge;
  }
  static constexpr const char* kNames[] = {"camera", "LiDAR",   "camera-LiDAR",
                                           "wheel",  "restart", "loop"};
  for (const auto& [name, kind] : kinds) {
    const double most = std::ceil(config.bundle.gate_share * kind.edges);
    if (kind.contradicted <= most && kind.worst <= config.bundle.gate_hard_chi2) continue;
    char text[200];
    std::snprintf(text, sizeof text,
                  "it contradicts %d of %d %s edges, worst from %ld to %ld (squared error %.1f, "
                  "gate %.1f)",
                  kind.contradicted, kind.edges, kNames[static_cast<int>(name)],
                  static_cast<long>(kind.edge.from.id), static_cast<long>(kind.edge.to.id),
                  kind.worst, config.bundle.gate_chi2);
    return text;
  }
  return "";
}

}  // namespace

BundleReport adjust_globally(const PoseGraphConfig& config, const SolveOptions& options,
                             const BundleQuestion& question, GraphNodes* nodes,
                             std::vector<GraphEdge>* edges) {
  BundleReport report;
  const std::vector<Track> tracks = known_tracks(config, question, *nodes);
  if (tracks.size() < static_cast<std::size_t>(config.bundle.least_points)) {
    report.reason = "only " + std::to_string(tracks.size()) + " points were seen twice";
    return report;
  }
  SparseProblem problem(config, options, *nodes,
                        without_double_counting(config.bundle, tracks, *edges));
  LandmarkNoise noise;
  noise.optimism = config.noise.visual_optimism;
  LandmarkPart landmarks(question.camera, question.T_base_camera, noise);
  for (const Track& track : tracks) {
    std::vector<LandmarkView> views;
    for (const Sight& sight : track) {
      const NodeId id = keyframe(sight.keyframe);
      views.push_back({problem.variable_of(id), nodes->at(id).T_map_base,
                       observation(config.bundle, question.camera, sight.seen)});
    }
    landmarks.add(first_guess(question, *nodes, track), std::move(views));
  }
  landmarks.make_pattern(problem.n_variables());
  problem.attach(&landmarks);
  report.landmarks = landmarks.n_landmarks();
  report.views = landmarks.n_views();

  Poses poses = problem.start();
  bool usable = true;
  // The points first, as well as these poses allow: what is gained after that is the poses' merit.
  landmarks.settle(poses);
  report.initial_cost = problem.cost(poses, 1.0);
  report.final_cost =
      problem.minimise(1.0, config.bundle.iterations, &poses, &report.iterations, &usable);
  if (!usable || !(report.final_cost < report.initial_cost)) {
    report.reason = usable ? "nothing to gain" : "the equations can't be solved";
    return report;
  }
  GraphNodes after = *nodes;
  problem.write_back(poses, &after);
  report.reason = contradiction(config, options.planar, *nodes, after, *edges);
  if (!report.reason.empty()) return report;

  report.accepted = true;
  for (const auto& [id, node] : after)
    report.largest_move_m =
        std::max(report.largest_move_m,
                 (node.T_map_base.translation() - nodes->at(id).T_map_base.translation()).norm());
  char text[160];
  std::snprintf(text, sizeof text, "%zu points, %zu sights: cost %.0f to %.0f, nodes moved %.3f m",
                report.landmarks, report.views, report.initial_cost, report.final_cost,
                report.largest_move_m);
  report.reason = text;
  *nodes = std::move(after);
  for (GraphEdge& edge : *edges)
    if (edge.kind == EdgeKind::kVisual && between_keyframes(edge))
      edge.adjusted = nodes->at(edge.from).T_map_base.inverse() * nodes->at(edge.to).T_map_base;
  return report;
}

}  // namespace fusion_slam
