#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "engine/organ_options.h"
#include "engine/reference_fem/block_matrix.h"
#include "engine/reference_fem/tetra_law.h"
#include "engine/reference_fem/tetra_mesh.h"

/// Linear and quadratic tetrahedral finite elements: the offline reference that the real-time
/// models are measured against. Set-up and tools only: allocates and takes seconds to minutes.
namespace hpdm {

/// The elastic energy of a mesh as a function of its nodes' displacements u (N x 3, m).
/// Quadrature: one point (linear) or four (quadratic, exact for small strain).
class TetraBody {
 public:
  /// `stiffness` (T): Young's modulus of each element over the material's; empty: all 1.
  TetraBody(TetraMesh mesh, const MaterialOptions& material, TetraLaw law,
            const Eigen::VectorXd& stiffness = {});

  const TetraMesh& mesh() const { return mesh_; }
  const MaterialOptions& options() const { return options_; }
  TetraLaw law() const { return material_.law(); }

  double Energy(const Points& u) const;                                 ///< J.
  Points Gradient(const Points& u) const;                               ///< dE/du, N x 3, N.
  void SetHessian(const Points& u, bool convex, BlockMatrix* K) const;  ///< d2E/du2, N/m.
  /// Relative change of volume: mean of det F - 1, or of tr e in small strain.
  double VolumeChange(const Points& u) const;

 private:
  struct Element {
    Eigen::Matrix<double, 4, 3> gradients;  ///< Gradients of the barycentric coordinates, 1/m.
    double volume;                          ///< m^3.
    double stiffness;                       ///< Relative.
  };
  /// Calls visit(element, shape gradients A x 3, volume m^3) at every quadrature point.
  template <typename Visit>
  void ForEachPoint(const Visit& visit) const;
  double Stiffness(Eigen::Index e) const {
    return elements_[static_cast<std::size_t>(e)].stiffness;
  }
  Matrix3d DeformationGradient(Eigen::Index e, const Eigen::Matrix<double, Eigen::Dynamic, 3>& dN,
                               const Points& u) const;

  TetraMesh mesh_;
  MaterialOptions options_;
  TetraMaterial material_;
  std::vector<Element> elements_;
};

/// A linear function of the nodes' displacements: sum of weight x u_node. Nodes may repeat.
using TetraRow = std::vector<std::pair<int, double>>;

/// A load on the row `patch`: a force distributed by its weights, or a prescribed displacement.
struct TetraLoad {
  TetraRow patch;
  std::optional<Vector3d> force;         ///< N.
  std::optional<Vector3d> displacement;  ///< m.
};

/// Supports and loads of a body.
struct TetraProblem {
  BlockMatrix springs;  ///< Springs to rest over the body's elements, N/m.
  Points forces;        ///< N x 3, N, in addition to the loads.
  std::vector<TetraLoad> loads;
};

/// Returns a problem without springs, forces and loads.
TetraProblem EmptyProblem(const TetraBody& body);

/// Returns the supports and loads of an organ with the posed rest surface `rest` (m, world), whose
/// tissue the body's mesh fills. Throws InputError if a support holds no tissue.
/// - Supports are springs per volume over the points in the region, 14 points per element, so they
///   act on regions of tissue and not of nodes.
/// - A fixed support is 1e6 E / L^2, L the mean edge of the surface's bounding box.
/// - Loads act through SurfaceKernel.
TetraProblem MakeTetraProblem(const TetraBody& body, const SurfaceMesh& rest,
                              const std::vector<SupportOptions>& supports,
                              const std::vector<LoadOptions>& loads);

struct TetraSolveOptions {
  int load_steps = 1;         ///< Equal load increments; small strain needs one.
  int most_iterations = 100;  ///< Newton iterations per load step.
  double tolerance = 1e-7;    ///< Residual forces over the loads' forces.
};

struct TetraSolution {
  Points u;                             ///< N x 3, m.
  std::vector<Vector3d> forces;         ///< One per load, N; computed if its displacement is given.
  std::vector<Vector3d> displacements;  ///< One per load's patch, m.
  double residual = 0;                  ///< Residual forces over the loads' forces.
  int newton_iterations = 0;
  int solver_iterations = 0;
  bool converged = false;

  /// Displacement of load `i` along its force over the force, m/N.
  double Compliance(std::size_t i = 0) const;
};

/// Returns the static equilibrium under all loads together. Newton's method with a backtracking
/// line search on the potential energy. An indefinite tangent is replaced by its convex part
/// (Teran, Sifakis, Irving, Fedkiw 2005). Prescribed rows are Lagrange multipliers. Tolerances are
/// relative, so the result does not depend on units. Throws InputError if nothing holds the body.
TetraSolution SolveTetra(const TetraBody& body, const TetraProblem& problem,
                         const TetraSolveOptions& options = TetraSolveOptions());

/// Returns the row of each surface point (m), in the element that contains it or the nearest one.
std::vector<TetraRow> PointRows(const TetraMesh& mesh, const Points& points);

/// Returns the displacement of each row, R x 3.
Points ApplyRows(const std::vector<TetraRow>& rows, const Points& u);

}  // namespace hpdm
