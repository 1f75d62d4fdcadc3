#include "engine/energy/finite_metric_energy.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

// Signs of a square's corners 00, 01, 10, 11 in its differences along the first and second axis.
constexpr double kFirst[4] = {-1, -1, 1, 1}, kSecond[4] = {-1, 1, -1, 1};

Matrix6d PositivePart(const Matrix6d& H) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(H);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

FiniteMetricEnergy::FiniteMetricEnergy(const Lattice& lattice, const Quadrature& tissue, double eta,
                                       double beta, const ScalarStiffness& supports)
    : rest_(lattice.ControlPoints()),
      linear_(supports + MetricStiffness(lattice, tissue, 0, beta)),
      linear_full_(FullStiffness::Zero(3 * rest_.rows(), 3 * rest_.rows())) {
  HPDM_CHECK(eta > 0);
  AddAlongEachAxis(linear_, &linear_full_);
  const TensorBasis& basis = lattice.basis();
  const auto spacing = [&](int axis) {
    return lattice.box().lengths[axis] * basis.axis(axis).spacing();
  };
  for (int i = 0; i < 3; ++i) {
    for (const DifferenceGroup& group : DifferenceWeights(lattice, tissue, {i})) {
      const int a = group.columns[0], b = group.columns[1];
      if (a < 0 || b < 0) continue;
      edges_.push_back({a, b, 1 / spacing(i), eta * group.weight});
    }
    for (int j = i + 1; j < 3; ++j) {
      for (const DifferenceGroup& group : DifferenceWeights(lattice, tissue, {i, j})) {
        Square square{{}, 0.5 / spacing(i), 0.5 / spacing(j), 2 * eta * group.weight};
        std::copy(group.columns.begin(), group.columns.end(), square.corners);
        if (*std::min_element(group.columns.begin(), group.columns.end()) >= 0) {
          squares_.push_back(square);
        }
      }
    }
  }
}

// Returns the differences of x along the square's two directions.
std::pair<Vector3d, Vector3d> FiniteMetricEnergy::Differences(const Square& square) const {
  Vector3d g = Vector3d::Zero(), k = Vector3d::Zero();
  for (int c = 0; c < 4; ++c) {
    g += kFirst[c] * square.inverse_g * x_.row(square.corners[c]).transpose();
    k += kSecond[c] * square.inverse_k * x_.row(square.corners[c]).transpose();
  }
  return {g, k};
}

double FiniteMetricEnergy::Energy(const Points& U) {
  double energy = U.cwiseProduct(linear_ * U).sum() / 2;
  x_ = rest_ + U;
  for (const Edge& edge : edges_) {
    const double G = ((x_.row(edge.b) - x_.row(edge.a)) * edge.inverse_h).squaredNorm();
    energy += edge.weight * (G - 1) * (G - 1);
  }
  for (const Square& square : squares_) {
    const auto [g, k] = Differences(square);
    const double G = g.dot(k);
    energy += square.weight * G * G;
  }
  return energy;
}

double FiniteMetricEnergy::Gradient(const Points& U, Points* gradient) {
  gradient->noalias() = linear_ * U;
  double energy = U.cwiseProduct(*gradient).sum() / 2;
  x_ = rest_ + U;
  for (const Edge& edge : edges_) {
    const Vector3d g = (x_.row(edge.b) - x_.row(edge.a)).transpose() * edge.inverse_h;
    const double G = g.squaredNorm();
    energy += edge.weight * (G - 1) * (G - 1);
    // alpha = 4 eta (G - G0) times the difference.
    const Vector3d force = 4 * edge.weight * (G - 1) * edge.inverse_h * g;
    gradient->row(edge.b) += force.transpose();
    gradient->row(edge.a) -= force.transpose();
  }
  for (const Square& square : squares_) {
    const auto [g, k] = Differences(square);
    const double G = g.dot(k);
    energy += square.weight * G * G;
    for (int c = 0; c < 4; ++c) {
      gradient->row(square.corners[c]) +=
          2 * square.weight * G *
          (kFirst[c] * square.inverse_g * k + kSecond[c] * square.inverse_k * g).transpose();
    }
  }
  return energy;
}

void FiniteMetricEnergy::Hessian(const Points& U, bool semi_definite, FullStiffness* K) {
  *K = linear_full_;
  x_ = rest_ + U;
  for (const Edge& edge : edges_) {
    // Hessian by g: 4 w ((G - 1) I + 2 g g^T), eigenvalues 4 w (3 G - 1) along g, 4 w (G - 1)
    // across.
    const Vector3d g = (x_.row(edge.b) - x_.row(edge.a)).transpose() * edge.inverse_h;
    const double G = g.squaredNorm();
    double across = G - 1, along = 2;
    if (semi_definite && across < 0) {
      along = G > 0 ? std::max(0.0, 3 * G - 1) / G : 0;
      across = 0;
    }
    const Matrix3d H = 4 * edge.weight * edge.inverse_h * edge.inverse_h *
                       (across * Matrix3d::Identity() + along * g * g.transpose());
    K->block<3, 3>(3 * edge.a, 3 * edge.a) += H;
    K->block<3, 3>(3 * edge.b, 3 * edge.b) += H;
    K->block<3, 3>(3 * edge.a, 3 * edge.b) -= H;
    K->block<3, 3>(3 * edge.b, 3 * edge.a) -= H;
  }
  for (const Square& square : squares_) {
    const auto [g, k] = Differences(square);
    // Hessian by (g, k): 2 w ((k, g) (k, g)^T + g . k [0 I; I 0]).
    Eigen::Matrix<double, 6, 1> slope;
    slope << k, g;
    Matrix6d H = slope * slope.transpose();
    H.topRightCorner<3, 3>().diagonal().array() += g.dot(k);
    H.bottomLeftCorner<3, 3>().diagonal().array() += g.dot(k);
    if (semi_definite) H = PositivePart(H);
    H *= 2 * square.weight;
    for (int c = 0; c < 4; ++c) {
      const double cg = kFirst[c] * square.inverse_g, ck = kSecond[c] * square.inverse_k;
      for (int d = 0; d < 4; ++d) {
        const double dg = kFirst[d] * square.inverse_g, dk = kSecond[d] * square.inverse_k;
        K->block<3, 3>(3 * square.corners[c], 3 * square.corners[d]) +=
            cg * dg * H.topLeftCorner<3, 3>() + cg * dk * H.topRightCorner<3, 3>() +
            ck * dg * H.bottomLeftCorner<3, 3>() + ck * dk * H.bottomRightCorner<3, 3>();
      }
    }
  }
}

double FiniteMetricEnergy::CollapsedShare(const Points& U) {
  // If 3 G < 1, the resisting force of an edge falls when the edge is compressed further.
  double collapsed = 0, all = 0;
  x_ = rest_ + U;
  for (const Edge& edge : edges_) {
    const double G = ((x_.row(edge.b) - x_.row(edge.a)) * edge.inverse_h).squaredNorm();
    all += edge.weight;
    if (3 * G < 1) collapsed += edge.weight;
  }
  return collapsed / all;
}

}  // namespace hpdm
