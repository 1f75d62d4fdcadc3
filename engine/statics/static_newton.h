#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/energy/elastic_energy.h"

namespace hpdm {

/// Static loads on a lattice: e equations, each a force along one column of `rows`.
struct StaticLoadRows {
  Eigen::MatrixXd rows;    ///< 3n x e: the generalised force (N) of a unit force on an equation.
  Eigen::VectorXd forces;  ///< e, N; of held equations ignored.
  Eigen::VectorXd moves;   ///< e, m: rows^T U + local f of held equations, else ignored.
  std::vector<bool> held;  ///< e: the displacement is given and the force is found.
  Eigen::MatrixXd local;   ///< e x e, m/N: moves the loads' points beside rows^T U.
};

struct StaticNewtonOptions {
  double tolerance = 1e-9;  ///< Of the residual |dE/dU - R f| / |R f|.
  int load_steps = 4;       ///< Equal shares of the loads to begin with; a failed one is halved,
  int max_halvings = 6;     ///< at most so often in a row.
  int max_iterations = 25;  ///< Newton iterations a load step,
  int max_total = 150;      ///< and in all.
};

/// Where the lattice rests under the loads, or how far it came.
struct StaticNewtonSolution {
  Points U;                ///< n x 3, m.
  Eigen::VectorXd forces;  ///< e, N: given or found.
  double share = 0;        ///< Of the loads that was reached: 1 unless a step failed for good.
  double residual = 0;     ///< |dE/dU - R f| / |R f| there, 0 without load.
  int iterations = 0;      ///< Newton iterations in all.
};

/// The stable equilibrium that is reached by raising all loads together from rest: Newton's method
/// with line search on E(U) - f . R^T U for each share of the loads, the held equations exact after
/// every iteration (by Lagrange multipliers in their compliance space). Finds a minimum, never a
/// saddle: where the Hessian is indefinite its positive part is used. A load step that does not
/// converge is retried at half the size, and given up where the energy cannot carry the load
/// (share < 1, U the last equilibrium). Deterministic; one thread; allocates.
StaticNewtonSolution SolveStaticLoads(const StaticLoadRows& loads, ElasticEnergy* energy,
                                      const StaticNewtonOptions& options = {});

}  // namespace hpdm
