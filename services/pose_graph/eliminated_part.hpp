// Variables that a graph's poses are solved without: each belongs to few poses and to no other of
// its kind, so its own equation is solved first and what is left speaks of poses only (Schur
// complement; Triggs et al. 2000, section 6.1). Landmarks are such.
#pragma once

#include <utility>
#include <vector>

#include "libs/geometry/pose.hpp"

namespace fusion_slam {

using Poses = std::vector<SE3>;

class EliminatedPart {
 public:
  virtual ~EliminatedPart() = default;

  // Pose variables that it couples, (smaller, larger); (i, i) for each that it touches.
  virtual const std::vector<std::pair<int, int>>& pairs() const = 0;
  // Half the robust sum of squares at these poses and its own variables as they are.
  virtual double cost(const Poses& poses) const = 0;
  // Equations at these poses, its own variables eliminated: H as blocks aligned to pairs() (row:
  // the smaller variable), and the gradient by variable.
  virtual void linearise(const Poses& poses) = 0;
  virtual const std::vector<Matrix6d>& blocks() const = 0;
  virtual const std::vector<Vector6d>& gradient() const = 0;
  // Its own variables follow a step of the poses, on trial: drop() takes it back.
  virtual void step(const std::vector<Vector6d>& pose_steps) = 0;
  virtual void drop() = 0;
};

}  // namespace fusion_slam
