#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "engine/contact/half_space.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"

namespace hpdm {

/// A lattice of many more cells than a session can step, solved iteratively. The error of a
/// session's lattice is estimated against it if there is no better reference.
///
/// 1. Model: quadratic B-splines in cubes over the organ's box, the energy "strain" in small strain
///    with projected dilatation (mixed_dilatation.h), and the supports of support.h. Functions are
///    split by connected tissue. It converges to the same solution as the lattices that it judges,
///    and as quadratic tetrahedra.
/// 2. Storage: stiffness as blocks of neighbouring control points, projections as sparse inner
///    products; nothing is dense. 10 kB per control point; solving takes seconds.
///
/// Set-up only; deterministic; const functions from any thread.
class FineLattice {
 public:
  /// `cells`: along the box's longest side. `rest`: posed, m. Ignores the lattice, the energy and
  /// the model in `organ`. Throws InputError (with the organ's name) if there is no tissue or a
  /// support holds none.
  FineLattice(const OrganOptions& organ, const SurfaceMesh& rest, int cells);

  int control_points() const { return lattice_.size(); }  ///< n.
  bool split() const { return lattice_.split(); }         ///< True if tissue splits functions.

  /// Returns the surface's displacements at equilibrium in each case (V x 3, m). The forces and
  /// displacements of a case act together. The indentation below the cells' size is that of a
  /// half-space (half_space.h). Four cases of forces cost little more than one. Throws InputError
  /// if a load touches no surface or is a pressure, or if nothing holds the organ.
  std::vector<Points> Displacements(const std::vector<std::vector<LoadOptions>>& cases) const;

 private:
  // Fields projected on the splines one degree lower, in the inner product of some tissue:
  //     int (P f)^2 = |L^-1 M f|^2,
  // with the moments M (m x columns) and L L^T (m x m) of the splines.
  struct Projection {
    double stiffness = 0;  // factor of int (P f)^2 in the energy
    WeightMatrix moments;
    std::unique_ptr<Eigen::SimplicialLLT<Eigen::SparseMatrix<double>>> inner;
    Eigen::VectorXd sums;  // m: row sums of the inner products, which the preconditioner uses
  };
  // Displacements or forces (3n x kTogether, m or N) that one pass over the stiffness solves for
  // together. Reading the stiffness dominates the time of an iteration.
  static constexpr int kTogether = 4;
  using Columns = Eigen::Matrix<double, Eigen::Dynamic, kTogether, Eigen::RowMajor>;
  // A load's resolved kernel on the lattice, and its unresolved indentation.
  struct Patch {
    Eigen::VectorXd weights;  // n
    LocalIndentation indentation;
  };
  // Knowns and solutions of one case's loads.
  struct Answer {
    std::vector<Patch> patches;
    Eigen::VectorXd force, moved;         // 3 per load, N and m: given values
    std::vector<Eigen::Index> held;       // equations whose displacement is given
    std::vector<Eigen::VectorXd> fields;  // 3n: under the given forces, then 1 N in each of `held`
  };

  // Tissue points of one cell and the functions that can be non-zero there.
  struct Cell {
    Eigen::Index begin = 0, end = 0;
    std::vector<int> columns;  // ascending
  };

  std::vector<Cell> FindCells(const struct TissueQuadrature& sampled) const;
  void FindNeighbours(const std::vector<Cell>& cells);
  std::size_t Neighbour(int a, int b) const;  // place of b among those of a
  void AddElasticity(const struct TissueQuadrature& sampled, const Quadrature& elastic);
  void AddCell(const Quadrature& elastic, const Cell& cell, double mu, double lambda,
               std::vector<double>* blocks) const;
  void AddSupports(const Quadrature& elastic);
  void Factorise();
  Projection Project(const Quadrature& tissue, const std::vector<WeightMatrix>& fields,
                     double stiffness) const;
  void Multiply(const Columns& x, Columns* y) const;
  Columns Solve(const Columns& loads) const;
  Patch PatchOf(const LoadOptions& load) const;
  Answer Ask(const std::vector<LoadOptions>& loads) const;  // `fields` hold the loads, N
  Points Compose(const std::vector<LoadOptions>& loads, Answer* answer) const;

  OrganOptions organ_;
  SurfaceMesh rest_;
  Box bounds_;
  Points normals_;
  SurfaceTopology topology_;
  Lattice lattice_;
  Eigen::VectorXd thickness_;  // V, m
  // Of control point a: the columns of the points whose functions meet its own in a cell, ascending,
  // at first_[a] .. first_[a + 1] - 1.
  std::vector<std::size_t> first_;
  std::vector<int> neighbours_;
  // 9 for each neighbour, N/m, row-major: pointwise elasticity. Every iteration reads it; float's
  // error is far below that of the cells.
  std::vector<float> blocks_;
  std::vector<Projection> dilatations_;   // moments m x 3n; none for nu <= 1/3
  std::vector<Projection> held_;          // of fixed supports: moments m x n
  WeightMatrix springs_;                  // n x n, N/m: the other supports
  std::vector<Matrix3d> preconditioner_;  // n: inverse of each control point's own block
};

}  // namespace hpdm
