#include "engine/reference_fem/tetra_solver.h"

#include <Eigen/LU>

namespace hpdm {
namespace {

constexpr int kMaxSolverIterations = 3000;

}  // namespace

TetraSolver::TetraSolver(const TetraMesh& mesh)
    : mesh_(mesh), coarse_(mesh.elements.leftCols(4), mesh.corners) {}

bool TetraSolver::Factorise(const BlockMatrix& K) {
  K_ = &K;
  inverse_diagonal_.resize(static_cast<std::size_t>(K.rows()));
  for (int i = 0; i < K.rows(); ++i) {
    for (int e = K.Start(i); e < K.Start(i + 1); ++e) {
      if (K.Column(e) == i) inverse_diagonal_[static_cast<std::size_t>(i)] = K.Block(e).inverse();
    }
  }
  fresh_ = false;
  const bool serves = fresh_iterations_ > 0 && last_iterations_ <= 2 * fresh_iterations_ + 10;
  return serves || Refactor();
}

bool TetraSolver::Refactor() {
  const BlockMatrix& K = *K_;
  // Coarse matrix P^T K P: a middle node moves by the mean of its two corners.
  coarse_.SetZero();
  struct Parents {
    int count;
    int node[2];
    double weight;
  };
  const auto parents = [&](int node) -> Parents {
    if (node < mesh_.corners) return {1, {node, node}, 1.0};
    const auto& [a, b] = mesh_.parents[static_cast<std::size_t>(node - mesh_.corners)];
    return {2, {a, b}, 0.5};
  };
  for (int i = 0; i < K.rows(); ++i) {
    const Parents rows = parents(i);
    for (int e = K.Start(i); e < K.Start(i + 1); ++e) {
      const Parents columns = parents(K.Column(e));
      for (int r = 0; r < rows.count; ++r) {
        for (int c = 0; c < columns.count; ++c) {
          coarse_.At(rows.node[r], columns.node[c]) += rows.weight * columns.weight * K.Block(e);
        }
      }
    }
  }
  const Eigen::SparseMatrix<double> lower = LowerTriangle(coarse_);
  if (!analysed_) factor_.analyzePattern(lower);
  analysed_ = true;
  factor_.factorize(lower);
  fresh_ = true;
  fresh_iterations_ = 0;
  return factor_.info() == Eigen::Success;
}

Points TetraSolver::Precondition(const Points& residual) const {
  const auto solve_coarse = [&](const Points& b) {
    const Eigen::Map<const Eigen::VectorXd> flat(b.data(), b.size());
    const Eigen::VectorXd x = factor_.solve(flat);
    return Points(Eigen::Map<const Points>(x.data(), b.rows(), 3));
  };
  if (!mesh_.quadratic()) return solve_coarse(residual);

  // Gauss-Seidel update of node i.
  Points x = Points::Zero(residual.rows(), 3);
  const auto relax = [&](int i) {
    Vector3d b = residual.row(i).transpose();
    for (int e = K_->Start(i); e < K_->Start(i + 1); ++e) {
      const int j = K_->Column(e);
      if (j != i) b.noalias() -= K_->Block(e) * x.row(j).transpose();
    }
    x.row(i) = (inverse_diagonal_[static_cast<std::size_t>(i)] * b).transpose();
  };
  const int nodes = static_cast<int>(residual.rows());
  for (int i = 0; i < nodes; ++i) relax(i);

  Points rest;
  K_->Multiply(x, &rest);
  rest = residual - rest;
  Points coarse = rest.topRows(mesh_.corners);
  for (int i = mesh_.corners; i < nodes; ++i) {
    for (const int parent : mesh_.parents[static_cast<std::size_t>(i - mesh_.corners)]) {
      coarse.row(parent) += rest.row(i) / 2;
    }
  }
  const Points correction = solve_coarse(coarse);
  x.topRows(mesh_.corners) += correction;
  for (int i = mesh_.corners; i < nodes; ++i) {
    for (const int parent : mesh_.parents[static_cast<std::size_t>(i - mesh_.corners)]) {
      x.row(i) += correction.row(parent) / 2;
    }
  }
  for (int i = nodes - 1; i >= 0; --i) relax(i);
  return x;
}

bool TetraSolver::Solve(const Points& b, double tolerance, Points* x) {
  const Points start = *x;
  if (TrySolve(b, tolerance, x)) return true;
  if (fresh_ || !Refactor()) return false;
  *x = start;
  return TrySolve(b, tolerance, x);
}

bool TetraSolver::TrySolve(const Points& b, double tolerance, Points* x) {
  if (x->rows() != b.rows()) *x = Points::Zero(b.rows(), 3);
  Points Kp;
  K_->Multiply(*x, &Kp);
  Points residual = b - Kp;
  const double goal = tolerance * b.norm();
  if (residual.norm() <= goal) return true;
  Points z = Precondition(residual);
  Points p = z;
  double rz = Dot(residual, z);
  // Beyond this number of iterations an old factor no longer pays.
  const int most = fresh_ ? kMaxSolverIterations : 10 * fresh_iterations_ + 50;
  last_iterations_ = 0;
  for (int i = 0; i < most; ++i) {
    ++iterations_;
    ++last_iterations_;
    K_->Multiply(p, &Kp);
    const double curvature = Dot(p, Kp);
    if (!(curvature > 0) || !(rz > 0)) return false;
    *x += rz / curvature * p;
    residual -= rz / curvature * Kp;
    if (residual.norm() <= goal) {
      if (fresh_iterations_ == 0) fresh_iterations_ = last_iterations_;
      return true;
    }
    z = Precondition(residual);
    const double next = Dot(residual, z);
    p = z + next / rz * p;
    rz = next;
  }
  return false;
}

}  // namespace hpdm
