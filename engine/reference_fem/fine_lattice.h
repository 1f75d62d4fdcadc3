#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "engine/contact/half_space.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"

namespace hpdm {

/// A lattice of many more cells than a session could step, solved iteratively: what the error of
/// those that a session can step is estimated against where nothing better is at hand. Quadratic
/// B-splines in cubes over the organ's box, the energy "strain" in small strain with projected
/// dilatation (mixed_dilatation.h), supports as those of support.h: it tends to the same answer as
/// the lattices that it judges, and to that of quadratic tetrahedra.
///
/// Nothing dense is made: stiffness is kept by the blocks of neighbouring control points, and the
/// projections by their sparse inner products. Some seconds and 10 kB a control point. Set-up
/// only; deterministic; const functions from any thread.
class FineLattice {
 public:
  /// `cells` along the box's longest side. `rest`: posed, m. Of `organ` the shape of the lattice,
  /// the energy and the model are not asked. Throws InputError (the organ's name) when it has no
  /// tissue or a support holds none.
  FineLattice(const OrganOptions& organ, const SurfaceMesh& rest, int cells);

  int control_points() const { return lattice_.size(); }  ///< n.

  /// Where the surface comes to rest in each case under its forces and displacements, which act
  /// together (V x 3, m). What a patch does below the cells' size is a half-space's (half_space.h).
  /// Four cases of forces cost little more than one. Throws InputError when a load touches no
  /// surface, is a pressure, or nothing holds the organ.
  std::vector<Points> Displacements(const std::vector<std::vector<LoadOptions>>& cases) const;

 private:
  // Fields projected on the splines one degree lower, in the inner product of some tissue:
  // int (P f)^2 = |L^-1 M f|^2 with the moments M (m x columns) and L L^T (m x m) of the splines.
  struct Projection {
    double stiffness = 0;  // of the energy's square
    WeightMatrix moments;
    std::unique_ptr<Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>> inner;
    Eigen::VectorXd sums;  // m: of the inner products' rows, which preconditioning takes for them
  };
  // Displacements or forces (3n x so many, m or N) that are solved for in one pass over the
  // stiffness, which is all that an iteration waits for.
  static constexpr int kTogether = 4;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, kTogether, Eigen::RowMajor>;
  // A load as the lattice gets it, and the rest of what it does.
  struct Patch {
    Eigen::VectorXd weights;  // n
    LocalIndentation indentation;
  };
  // Of a case's loads: what is solved for, and what is known of the rest.
  struct Answer {
    std::vector<Patch> patches;
    Eigen::VectorXd force, moved;         // 3 a load, N and m: what is given
    std::vector<Eigen::Index> held;       // equations whose displacement is given
    std::vector<Eigen::VectorXd> fields;  // 3n: of the given forces, then of 1 N in each of `held`
  };

  void AddElasticity(const struct TissueQuadrature& sampled, const Quadrature& elastic);
  void AddCell(const Quadrature& elastic, Eigen::Index begin, Eigen::Index end, double mu,
               double lambda, std::vector<double>* blocks) const;
  void AddSupports(const Quadrature& elastic);
  void Factorise();
  Projection Project(const Quadrature& tissue, const std::vector<WeightMatrix>& fields,
                     double stiffness) const;
  void Multiply(const Columns& x, Columns* y) const;
  Columns Solve(const Columns& loads) const;
  Patch PatchOf(const LoadOptions& load) const;
  Answer Ask(const std::vector<LoadOptions>& loads) const;  // `fields` are the loads' own: N
  Points Compose(const std::vector<LoadOptions>& loads, Answer* answer) const;

  OrganOptions organ_;
  SurfaceMesh rest_;
  Box bounds_;
  Points normals_;
  SurfaceTopology topology_;
  Lattice lattice_;
  Eigen::VectorXd thickness_;    // V, m
  std::vector<int> neighbours_;  // n x 125: columns of the control points around each, or -1
  std::vector<float> blocks_;    // n x 125 x 9, N/m, row-major: pointwise elasticity; as read in
                                 // every iteration, and exact to far less than the cells are
  std::vector<Projection> dilatations_;   // moments m x 3n; none for nu <= 1/3
  std::vector<Projection> held_;          // of fixed supports: moments m x n
  WeightMatrix springs_;                  // n x n, N/m: of the other supports
  std::vector<Matrix3d> preconditioner_;  // n: inverse of each control point's own block
};

}  // namespace hpdm
