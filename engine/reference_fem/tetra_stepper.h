#pragma once

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <cstddef>
#include <functional>
#include <vector>

#include "engine/reference_fem/corotational.h"
#include "engine/reference_fem/tetra_fem.h"

namespace hpdm {

/// The elastic body of a TetraStepper: what differs from law to law.
struct SteppedBody {
  const TetraMesh* mesh = nullptr;
  /// Sets the gradient of the energy (N x 3, N), the elastic forces with the opposite sign, at
  /// displacements u (N x 3, m).
  std::function<void(const Points& u, Points* gradient)> gradient;
  /// Sets the gradient and the tangent stiffness, N/m.
  std::function<void(const Points& u, Points* gradient, BlockMatrix* K)> tangent;
  /// J; empty for forces that are not the gradient of an energy: then every step is taken in full.
  std::function<double(const Points& u)> energy;
  bool linear = false;  ///< The tangent is that at rest.
};

/// The body must outlive what is returned.
SteppedBody Stepped(const TetraBody& body);
SteppedBody Stepped(const CorotationalBody& body);

/// How a TetraStepper finds the equilibrium of a step.
enum class StepMethod {
  kQuasiNewton,  ///< The stiffness at rest, factorised once, with L-BFGS (Liu, Bouaziz, Kavan 2017).
  kNewton,       ///< The tangent is factorised in each round.
  kConjugateGradients,  ///< The tangent is solved by conjugate gradients, preconditioned by blocks.
};

/// Tetrahedra as a real-time simulator steps them: the loads' patches move by a little, and the body
/// follows from its last equilibrium. What the engine's own step is compared with. A step may have
/// other patches than the last one, so nothing of them is kept. Allocates; tools only.
class TetraStepper {
 public:
  /// Analyses and factorises the stiffness at rest. `springs`: the supports (MakeTetraProblem), which
  /// must outlive this. Throws InputError if nothing holds the body.
  /// A step ends after `most_rounds` at the latest. With one round a solver follows the tangent, as
  /// simulators do that solve one linear system a step.
  TetraStepper(SteppedBody body, const BlockMatrix& springs, StepMethod method,
               int most_rounds = 200);

  /// Residual forces over the forces at the patches, at which a step ends.
  static constexpr double kTolerance = 1e-3;

  struct Result {
    int rounds = 0;  ///< Evaluations of the gradient or solves of the tangent.
    bool converged = false;
  };
  /// Finds the equilibrium in which each patch is displaced by its row of `displacements` (L x 3, m).
  Result MoveTo(const std::vector<TetraRow>& patches, const Points& displacements);

  const Points& u() const { return u_; }            ///< N x 3, m.
  const Points& forces() const { return forces_; }  ///< L x 3, N: of the patches on the body.

  /// Entries of the factor of the stiffness at rest; 0 with conjugate gradients.
  std::size_t factor_entries() const;

  /// Returns K^-1 b of the stiffness at rest, N x 3.
  Points SolveAtRest(const Points& b) const;

 private:
  struct Pair {
    Points s, y;
    double rho;
  };
  class Patches;

  Points Inverse(const Points& b) const;
  Points Gradient(const Points& u) const;
  double Potential(const Points& u) const;
  void Linearise(Points* gradient);
  bool Factorise();
  Points Direction(const Patches& patches, const Points& gradient) const;
  Points ByConjugateGradients(const Patches& patches, const Points& residual) const;
  double Shorten(const Points& step, const Points& gradient) const;

  SteppedBody body_;
  const BlockMatrix& springs_;
  StepMethod method_;
  int most_rounds_;
  BlockMatrix K_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  std::vector<Matrix3d> inverse_diagonal_;
  std::vector<Pair> pairs_;
  Points u_, forces_;
};

}  // namespace hpdm
