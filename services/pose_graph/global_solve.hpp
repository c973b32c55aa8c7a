// The whole graph solved anew, on a copy, in a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <future>
#include <memory>
#include <vector>

#include "services/pose_graph/global_bundle.hpp"
#include "services/pose_graph/graph_solver.hpp"

namespace fusion_slam {

struct GlobalSolve {                             // question and answer
  std::shared_ptr<const BundleQuestion> bundle;  // with it: global bundle adjustment afterwards
  BundleReport bundle_report;
  PoseGraphConfig config;
  SolveOptions options;
  GraphNodes nodes;
  std::vector<GraphEdge> edges;
  SolveReport report;
  std::int64_t took_us = 0;  // of the clock on the wall; live only
};

struct BackgroundSolve {
  BackgroundSolve() = default;
  BackgroundSolve(const BackgroundSolve&) = delete;
  BackgroundSolve& operator=(const BackgroundSolve&) = delete;
  ~BackgroundSolve() { *unwanted = true; }  // and waits for the step it is at
  std::int64_t meet_us = 0;                 // measurement time at which the answer is taken over
  SE3 T_now_then = SE3::Identity();         // how the whole map has been moved since it was asked
  bool outdated = false;                    // since then the nodes were moved by a better answer
  std::shared_ptr<std::atomic<bool>> unwanted = std::make_shared<std::atomic<bool>>(false);
  std::future<GlobalSolve> answer;
};

// In a thread of its own, which config.solver_begins is called in first.
std::future<GlobalSolve> solve_elsewhere(GlobalSolve question);

}  // namespace fusion_slam
