// Landmarks as a part of the pose graph's equations: what keyframes saw of them, robust against
// wrong matches.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "libs/camera/camera_model.hpp"
#include "libs/features/correspondence.hpp"
#include "services/pose_graph/eliminated_part.hpp"

namespace fusion_slam {

struct LandmarkView {  // one sight of one landmark
  int variable = -1;   // the keyframe's pose; -1: it stands still at T_map_base
  SE3 T_map_base = SE3::Identity();
  Correspondence seen;  // p_reference is not used
};

struct LandmarkNoise {
  // Squared whitened error where doubt begins (Cauchy's loss): 95 % of a chi-square with 2 degrees
  // of freedom, with 3 where there is depth.
  double doubt_2d = 5.99;
  double doubt_3d = 7.81;
  double optimism = 9.0;  // on the covariance of each sight, so that its edges are believed, too
};

// Residual: pose_residual() of libs/features. Not thread-safe.
class LandmarkPart final : public EliminatedPart {
 public:
  LandmarkPart(const CameraModel& camera, const SE3& T_base_camera, const LandmarkNoise& noise);

  // A landmark at p_map_m with its sights, each from another pose. Before the first solve.
  void add(const Eigen::Vector3d& p_map_m, std::vector<LandmarkView> views);
  // Moves the points alone to where they fit best, the poses standing still (Gauss-Newton with
  // step halving).
  void settle(const Poses& poses);
  // After the last add().
  void make_pattern(int n_variables);

  const std::vector<std::pair<int, int>>& pairs() const override { return pairs_; }
  double cost(const Poses& poses) const override;
  void linearise(const Poses& poses) override;
  const std::vector<Matrix6d>& blocks() const override { return blocks_; }
  const std::vector<Vector6d>& gradient() const override { return gradient_; }
  void step(const std::vector<Vector6d>& pose_steps) override;
  void drop() override;

  std::size_t n_landmarks() const { return landmarks_.size(); }
  std::size_t n_views() const { return n_views_; }
  const Eigen::Vector3d& point(std::size_t landmark) const { return landmarks_[landmark].p_map_m; }
  // Sights whose squared error is above the doubt.
  int n_doubted(const Poses& poses) const;

 private:
  using Matrix63d = Eigen::Matrix<double, 6, 3>;
  struct Landmark {
    Eigen::Vector3d p_map_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d before_m = Eigen::Vector3d::Zero();  // the last step
    std::vector<LandmarkView> views;
    std::vector<int> pair_of;  // block of views (a, b), a <= b, row by row; -1: one stands still
    std::vector<Matrix63d> W;  // of the last linearisation, by view
    Eigen::Matrix3d V_inverse = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
  };
  bool residual(const Landmark& landmark, const LandmarkView& view, const Poses& poses,
                Eigen::Vector3d* r, Eigen::Matrix<double, 3, 6>* by_pose,
                Eigen::Matrix3d* by_point) const;
  double doubt(const LandmarkView& view) const;
  double cost_of(const Landmark& landmark, const Poses& poses) const;
  void settle_one(const Poses& poses, Landmark* landmark) const;
  void eliminate(const Poses& poses, Landmark* landmark);

  CameraModel camera_;
  SE3 T_base_camera_;
  Matrix6d camera_by_base_;  // adjoint: a base's step as the camera's
  LandmarkNoise noise_;
  std::size_t n_views_ = 0;
  std::vector<Landmark> landmarks_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<Matrix6d> blocks_;
  std::vector<Vector6d> gradient_;
};

}  // namespace fusion_slam
