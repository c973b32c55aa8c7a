#include "services/pose_graph/normal_equations.hpp"

namespace fusion_slam {
namespace {

constexpr int kMostSteps = 200;
constexpr double kEnough = 1e-5;  // of |g|: what is left undone

}  // namespace

double NormalEquations::Cholesky::work() const {
  return 0.5 * m_nonZerosPerCol.cast<double>().squaredNorm();
}

bool NormalEquations::solve(const Eigen::VectorXd& g, Eigen::VectorXd* x) {
  if (!cholesky_ && !too_full_) {
    cholesky_.emplace().analyzePattern(H);
    too_full_ = cholesky_->work() > most_work;
    if (too_full_) cholesky_.reset();
    gradients_.setMaxIterations(kMostSteps);
    gradients_.setTolerance(kEnough);
  }
  if (cholesky_) {
    cholesky_->factorize(H);
    if (cholesky_->info() != Eigen::Success) return false;
    *x = cholesky_->solve(g);
    return true;
  }
  gradients_.compute(H);
  if (gradients_.info() != Eigen::Success) return false;
  *x = gradients_.solve(g);
  return x->allFinite();
}

}  // namespace fusion_slam
