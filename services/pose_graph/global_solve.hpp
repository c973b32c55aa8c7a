// The whole graph solved anew, on a copy, in a thread of its own.
#pragma once

#include <cstdint>
#include <future>
#include <vector>

#include "services/pose_graph/graph_solver.hpp"

namespace fusion_slam {

struct GlobalSolve {  // question and answer
  PoseGraphConfig config;
  SolveOptions options;
  GraphNodes nodes;
  std::vector<GraphEdge> edges;
  SolveReport report;
};

struct BackgroundSolve {
  std::int64_t started_us = 0;  // measurement time
  std::future<GlobalSolve> answer;
};

}  // namespace fusion_slam
