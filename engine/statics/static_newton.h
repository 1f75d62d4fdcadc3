#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/energy/elastic_energy.h"

namespace hpdm {

/// Static loads on a lattice: e equations, each a force along one column of `rows`.
struct StaticLoadRows {
  /// 3(n + slots) x e: the generalised force (N) of a unit force on an equation.
  Eigen::MatrixXd rows;
  Eigen::VectorXd forces;  ///< e, N: given forces; ignored for held equations.
  Eigen::VectorXd moves;   ///< e, m: given rows^T U + local f; ignored unless held.
  std::vector<bool> held;  ///< e: the displacement is given and the force is found.
  Eigen::MatrixXd local;   ///< e x e, m/N: local compliance, in addition to rows^T U.
};

struct StaticNewtonOptions {
  double tolerance = 1e-9;  ///< Largest residual |dE/dU - R f| / |R f|.
  int load_steps = 4;       ///< Equal shares of the loads at first; a failed step is halved.
  int max_halvings = 6;     ///< Consecutive halvings.
  int max_iterations = 25;  ///< Newton iterations per load step.
  int max_total = 150;      ///< Newton iterations in all.
};

/// Equilibrium under the share of the loads that was reached.
struct StaticNewtonSolution {
  Points U;                ///< (n + slots) x 3, m.
  Eigen::VectorXd forces;  ///< e, N: given or found.
  double share = 0;        ///< Share of the loads that was reached: 1 unless a step failed.
  double residual = 0;     ///< |dE/dU - R f| / |R f| there, 0 without load.
  int iterations = 0;      ///< Newton iterations in all.
};

/// Finds the stable equilibrium by raising all loads together from rest.
///
/// 1. Each share of the loads is solved by Newton's method with line search on E(U) - f . R^T U.
/// 2. Held equations are exact after every iteration (Lagrange multipliers in compliance space).
/// 3. The result is a minimum, never a saddle: an indefinite Hessian is replaced by its positive
///    part.
/// 4. A load step that does not converge is retried at half the size. If the energy cannot carry
///    the load, share < 1 and U is the last equilibrium.
///
/// Deterministic; one thread; allocates.
StaticNewtonSolution SolveStaticLoads(const StaticLoadRows& loads, ElasticEnergy* energy,
                                      const StaticNewtonOptions& options = {});

}  // namespace hpdm
