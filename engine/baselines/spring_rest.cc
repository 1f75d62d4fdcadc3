#include "engine/baselines/spring_rest.h"

#include <Eigen/SparseCholesky>

#include "engine/base/error.h"

namespace hpdm {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

// Returns the stiffness of all springs, those to rest included, without the negative parts.
Matrix Tangent(const MassSpring& model, const Points& p) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(36 * model.springs().size() + 3 * static_cast<std::size_t>(p.rows()));
  for (const Spring& spring : model.springs()) {
    const Vector3d l = p.row(spring.a) - p.row(spring.b);
    const double length = std::max(l.norm(), 1e-9 * spring.length);
    const Vector3d d = l / length;
    const double across = spring.stiffness * std::max(0.0, 1 - spring.length / length);
    const Matrix3d K =
        across * Matrix3d::Identity() + (spring.stiffness - across) * d * d.transpose();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        entries.emplace_back(3 * spring.a + i, 3 * spring.a + j, K(i, j));
        entries.emplace_back(3 * spring.b + i, 3 * spring.b + j, K(i, j));
        entries.emplace_back(3 * spring.a + i, 3 * spring.b + j, -K(i, j));
        entries.emplace_back(3 * spring.b + i, 3 * spring.a + j, -K(i, j));
      }
    }
  }
  for (int v = 0; v < p.rows(); ++v) {
    for (int d = 0; d < 3; ++d) entries.emplace_back(3 * v + d, 3 * v + d, model.ground()[v]);
  }
  Matrix K(3 * p.rows(), 3 * p.rows());
  K.setFromTriplets(entries.begin(), entries.end());
  return K;
}

}  // namespace

SpringRest RestUnderLoads(const MassSpring& model, const Eigen::MatrixXd& rows,
                          const LoadForces& load_forces, const std::string& name) {
  constexpr int kMaxIterations = 100;
  constexpr double kTolerance = 1e-8;
  SpringRest at{Points::Zero(model.rest().rows(), 3), Eigen::VectorXd::Zero(rows.cols())};
  Eigen::Map<Eigen::VectorXd> u(at.displacements.data(), at.displacements.size());
  Eigen::SimplicialLDLT<Matrix> factor;
  Eigen::MatrixXd columns(rows.rows(), 1 + rows.cols());
  // Energy minus the work of the loads. Held patches stay at their place after the first step.
  const auto potential = [&](const Points& moved) {
    return model.StoredEnergy(moved) -
           at.forces.dot(rows.transpose() *
                         Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size()));
  };
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Points pull = model.RestoringForces(at.displacements);
    const Eigen::Map<const Eigen::VectorXd> gradient(pull.data(), pull.size());
    const Eigen::VectorXd load = rows * at.forces;
    if (iteration > 0 && (gradient - load).norm() <= kTolerance * load.norm()) break;

    const Matrix K = Tangent(model, model.rest() + at.displacements);
    if (iteration == 0) factor.analyzePattern(K);
    factor.factorize(K);
    // The last pivot of a singular matrix is round-off.
    if (factor.info() != Eigen::Success ||
        factor.vectorD().minCoeff() <= 1e-12 * factor.vectorD().maxCoeff()) {
      throw InputError("organ \"" + name +
                       "\": its springs leave some motion free; add an [[organ.support]]");
    }
    columns << -gradient, rows;
    columns = factor.solve(columns).eval();
    const auto response = columns.rightCols(rows.cols());
    at.forces = load_forces(rows.transpose() * response, rows.transpose() * (u + columns.col(0)));
    const Eigen::VectorXd step = columns.col(0) + response * at.forces;
    const Eigen::Map<const Points> moves(step.data(), at.displacements.rows(), 3);

    double length = 1;
    if (iteration > 0) {
      const double slope = (gradient - rows * at.forces).dot(step);
      const double start = potential(at.displacements);
      const double slack = 1e-13 * model.StoredEnergy(at.displacements);  // round-off
      for (int halving = 0; halving < 20; ++halving, length /= 2) {
        const Points moved = at.displacements + length * moves;
        if (potential(moved) <= start + 1e-4 * length * slope + slack) break;
      }
    }
    u += length * step;
  }
  return at;
}

}  // namespace hpdm
