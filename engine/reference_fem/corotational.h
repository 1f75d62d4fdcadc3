#pragma once

#include <vector>

#include "engine/organ_options.h"
#include "engine/reference_fem/block_matrix.h"

namespace hpdm {

/// Linear tetrahedra whose small-strain stiffness rotates with each element (Mueller and Gross
/// 2004). The rotation comes from two of its edges (the "large" method of Nesme, Payan, Faure
/// 2005), as in simulators in use today. It serves only for comparison with their recorded results:
/// the forces are not the gradient of an energy. The reference solution is TetraBody.
class CorotationalBody {
 public:
  /// `mesh`: linear.
  CorotationalBody(TetraMesh mesh, const MaterialOptions& material);

  const TetraMesh& mesh() const { return mesh_; }

  /// Computes the elastic forces on the nodes (N x 3, N) at displacements u (N x 3, m). Also
  /// computes the stiffness (N/m) for small changes of u with the rotations held.
  void Evaluate(const Points& u, Points* forces, BlockMatrix* K) const;

  /// Mass of each node, kg: a quarter of the elements around it.
  Eigen::VectorXd LumpedMasses(double density) const;

 private:
  struct Element {
    Matrix3d frame;                           ///< Columns: the axes from the edges at rest.
    Eigen::Matrix<double, 12, 12> stiffness;  ///< Stiffness at rest, world axes.
    double volume;
  };

  TetraMesh mesh_;
  std::vector<Element> elements_;
};

/// Returns the static equilibrium of a corotational body under `forces` (N x 3, N), with the listed
/// nodes held. Throws InputError if it is not reached.
Points SolveCorotational(const CorotationalBody& body, const std::vector<int>& held,
                         const Points& forces);

/// Ties nodes to rest so stiffly that they do not move: 1e6 times the largest stiffness around.
void HoldNodes(const std::vector<int>& nodes, BlockMatrix* K);

}  // namespace hpdm
