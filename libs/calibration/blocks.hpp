// Least squares whose uncertainty is measured, not believed: the drive is cut into blocks of time,
// each block's normal equations are kept apart, and the spread of the solutions without one block
// each (the delete-one jackknife, Tukey 1958; Efron & Stein 1981) is the covariance. Errors that
// neighbouring measurements share (one wall, one turn) are counted as what they are.
#pragma once

#include <cstddef>
#include <map>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace fusion_slam {

template <int N>
class BlockEquations {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  // A residual r with its derivative J = dr/dx and weight.
  void add(std::int64_t block, const Vector& jacobian, double residual, double weight) {
    Block& b = blocks_[block];
    b.H += weight * jacobian * jacobian.transpose();
    b.g += weight * residual * jacobian;
    b.cost += 0.5 * weight * residual * residual;
    ++n_;
  }
  void add_prior(const Vector& precision, const Vector& residual) {
    prior_.H += Matrix(precision.asDiagonal());
    prior_.g += precision.cwiseProduct(residual);
  }
  std::size_t residuals() const { return n_; }
  std::size_t blocks() const { return blocks_.size(); }

  // The step that makes the sum of squares least. Zero when nothing is known.
  Vector step() const {
    const Block all = sum();
    return -all.H.ldlt().solve(all.g);
  }
  // Of the solution x, at the solution.
  Matrix covariance() const {
    const Block all = sum();
    const auto n = static_cast<double>(blocks_.size());
    if (n < 2) return Matrix::Identity() * 1e6;
    Vector mean = Vector::Zero();
    std::map<std::int64_t, Vector> without;
    for (const auto& [id, b] : blocks_) {
      without[id] = -(all.H - b.H).ldlt().solve(all.g - b.g);
      mean += without[id] / n;
    }
    Matrix spread = Matrix::Zero();
    for (const auto& [id, x] : without) spread += (x - mean) * (x - mean).transpose();
    return spread * (n - 1.0) / n;
  }

 private:
  struct Block {
    Matrix H = Matrix::Zero();
    Vector g = Vector::Zero();
    double cost = 0.0;
  };
  Block sum() const {
    Block all = prior_;
    for (const auto& [id, b] : blocks_) {
      all.H += b.H;
      all.g += b.g;
    }
    return all;
  }
  std::map<std::int64_t, Block> blocks_;
  Block prior_;
  std::size_t n_ = 0;
};

}  // namespace fusion_slam
