#include "engine/reference_fem/corotational.h"

#include <Eigen/LU>
#include <algorithm>

#include "engine/base/error.h"
#include "engine/reference_fem/tetra_law.h"
#include "engine/reference_fem/tetra_solver.h"

namespace hpdm {
namespace {

/// Returns axes along the first edge, across it in the plane of the second, and normal to both.
Matrix3d FrameOfEdges(const Vector3d& first, const Vector3d& second) {
  const Vector3d x = first.normalized();
  const Vector3d z = first.cross(second).normalized();
  Matrix3d frame;
  frame << x, z.cross(x), z;
  return frame;
}

}  // namespace

CorotationalBody::CorotationalBody(TetraMesh mesh, const MaterialOptions& material)
    : mesh_(std::move(mesh)) {
  const Matrix9d C =
      TetraMaterial(material, TetraLaw::kSmallStrain).Tangent(Matrix3d::Identity(), false);
  for (Eigen::Index e = 0; e < mesh_.elements.rows(); ++e) {
    const Matrix3d edges = CornerEdges(mesh_, e);
    Eigen::Matrix<double, 4, 3> gradients;
    gradients.bottomRows(3) = edges.inverse();
    gradients.row(0) = -gradients.bottomRows(3).colwise().sum();
    // Columns: dF / d(component of a corner), as in Matrix9d.
    Eigen::Matrix<double, 9, 12> dF = Eigen::Matrix<double, 9, 12>::Zero();
    for (int a = 0; a < 4; ++a) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) dF(i + 3 * j, 3 * a + i) = gradients(a, j);
      }
    }
    Element element;
    element.frame = FrameOfEdges(edges.col(0), edges.col(1));
    element.volume = edges.determinant() / 6;
    element.stiffness = element.volume * dF.transpose() * C * dF;
    elements_.push_back(element);
  }
}

void CorotationalBody::Evaluate(const Points& u, Points* forces, BlockMatrix* K) const {
  forces->setZero(u.rows(), 3);
  K->SetZero();
  const Points now = mesh_.nodes + u;
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    const auto nodes = mesh_.elements.row(static_cast<Eigen::Index>(e));
    const Element& element = elements_[e];
    const Vector3d origin = now.row(nodes[0]).transpose();
    const Matrix3d R = FrameOfEdges(now.row(nodes[1]).transpose() - origin,
                                    now.row(nodes[2]).transpose() - origin) *
                       element.frame.transpose();
    Eigen::Matrix<double, 12, 1> stretch;  // displacements without the rotation
    for (int a = 0; a < 4; ++a) {
      stretch.segment<3>(3 * a) =
          R.transpose() * (now.row(nodes[a]).transpose() - origin) -
          (mesh_.nodes.row(nodes[a]) - mesh_.nodes.row(nodes[0])).transpose();
    }
    const Eigen::Matrix<double, 12, 1> force = element.stiffness * stretch;
    for (int a = 0; a < 4; ++a) {
      forces->row(nodes[a]) -= (R * force.segment<3>(3 * a)).transpose();
      for (int b = 0; b < 4; ++b) {
        K->At(nodes[a], nodes[b]) +=
            R * element.stiffness.block<3, 3>(3 * a, 3 * b) * R.transpose();
      }
    }
  }
}

Eigen::VectorXd CorotationalBody::LumpedMasses(double density) const {
  Eigen::VectorXd masses = Eigen::VectorXd::Zero(mesh_.nodes.rows());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    for (int k = 0; k < 4; ++k) {
      masses[mesh_.elements(static_cast<Eigen::Index>(e), k)] += density * elements_[e].volume / 4;
    }
  }
  return masses;
}

void HoldNodes(const std::vector<int>& nodes, BlockMatrix* K) {
  double largest = 0;
  for (int i = 0; i < K->rows(); ++i) largest = std::max(largest, K->At(i, i).norm());
  for (const int node : nodes) K->At(node, node) += 1e6 * largest * Matrix3d::Identity();
}

Points SolveCorotational(const CorotationalBody& body, const std::vector<int>& held,
                         const Points& forces) {
  constexpr int kMaxIterations = 500;
  constexpr double kTolerance = 1e-9;  // residual over the forces
  const int nodes = static_cast<int>(body.mesh().nodes.rows());
  BlockMatrix K(body.mesh().elements, nodes);
  TetraSolver solver(body.mesh());
  Points u = Points::Zero(nodes, 3), elastic;
  for (int i = 0; i < kMaxIterations; ++i) {
    body.Evaluate(u, &elastic, &K);
    Points residual = forces + elastic;
    for (const int node : held) residual.row(node).setZero();
    if (residual.norm() <= kTolerance * forces.norm()) return u;
    HoldNodes(held, &K);
    Points step;
    if (!solver.Factorise(K) || !solver.Solve(residual, kTolerance, &step)) break;
    u += step;
  }
  throw InputError("corotational tetrahedra: no equilibrium; hold more nodes or lower the forces");
}

}  // namespace hpdm
