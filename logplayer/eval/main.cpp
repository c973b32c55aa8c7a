// eval: scores a trajectory against a reference trajectory or verified relations, and a map against
// a reference map. See docs/evaluation.md.
#include <exception>
#include <iostream>

#include "logplayer/eval/run_eval.hpp"

int main(int argc, char** argv) {
  fusion_slam::EvalOptions options;
  const int usage = fusion_slam::parse_command_line(argc, argv, options);
  if (usage >= 0) return usage;
  try {
    return fusion_slam::run_eval(options);
  } catch (const std::exception& error) {
    std::cerr << "eval: " << error.what() << '\n';
    return 1;
  }
}
