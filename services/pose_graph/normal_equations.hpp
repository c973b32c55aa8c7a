// The damped normal equations H x = g of a pose graph: by sparse Cholesky while its factor is
// sparse, else by conjugate gradients.
#pragma once

#include <optional>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

namespace fusion_slam {

// Not thread-safe. Same input, same bits: which of the two solves is told by the pattern of H
// alone.
class NormalEquations {
 public:
  // Symmetric; only the lower triangle is read. Its pattern stays as at the first solve().
  Eigen::SparseMatrix<double> H;
  // Multiplications a factorisation may take. A robot that goes round and round in the same rooms
  // sees everything from everywhere: the factor fills up and would take minutes, while each node is
  // a few edges from each other one, which conjugate gradients like.
  double most_work = 2e9;

  // False: H is not positive definite. By conjugate gradients x is as good as a step towards it
  // (Nash & Sofer 1990: inexact steps do for a minimisation that looks whether the cost falls).
  bool solve(const Eigen::VectorXd& g, Eigen::VectorXd* x);

 private:
  using Matrix = Eigen::SparseMatrix<double>;
  struct Cholesky : Eigen::SimplicialLLT<Matrix, Eigen::Lower, Eigen::NaturalOrdering<int>> {
    double work() const;  // multiplications of a factorisation; after analyzePattern
  };
  // Incomplete factorisation with the pattern of H (Lin & More 1999).
  using Gradients = Eigen::ConjugateGradient<
      Matrix, Eigen::Lower,
      Eigen::IncompleteCholesky<double, Eigen::Lower, Eigen::NaturalOrdering<int>>>;
  std::optional<Cholesky> cholesky_;
  Gradients gradients_;
  bool too_full_ = false;
};

}  // namespace fusion_slam
