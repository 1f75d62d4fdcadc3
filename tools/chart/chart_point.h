#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/shared/timing.h"

namespace hpdm {

/// One model on one load case: how far from the reference solution and how long a step.
struct ChartPoint {
  std::string load_case;
  bool hollow = false;
  std::string model;   ///< hpdm, continuum, mass_spring, linear_tetrahedra, linear_graded.
  std::string energy;  ///< strain or metric; empty where there is no lattice.
  std::string strain;  ///< small or finite; metric: the domain, organ or box.
  std::string basis;
  std::string solver;
  int degree = 0;
  std::array<int, 3> cells = {0, 0, 0};  ///< Along each axis.
  int unknowns = 0;                      ///< Control points, vertices or nodes.
  int local_functions = 0;
  int local_refinement = 0;

  double error = 0;                        ///< Area-weighted relative L2 against the reference
                                           ///< solution.
  std::optional<double> compliance_ratio;  ///< Over the reference solution's; absent when fitted.
  bool fitted = false;  ///< No modulus in pascals: pressed as deep as makes the error least.
  std::optional<int> iterations;  ///< Of one step.
  std::optional<double> residual;
  bool converged = true;  ///< The step within its budget, the load within its tolerance.

  std::optional<double> setup_ms;
  std::optional<Timing> response;        ///< Reposition and relax.
  std::optional<Timing> relocation;      ///< Of the case's own vertices.
  std::optional<Timing> relocation_30k;  ///< Of 15,000 vertices: a surface of 30,000 triangles.

  /// What a step is charged with: response, and the relocation of 30,000 triangles. The surface
  /// models move their vertices in the response. Without times: infinity.
  double StepMicroseconds() const;
  double StepMinimumMicroseconds() const;
};

/// All figures in the order of the columns; null where one is absent. Stable: scripts read it.
nlohmann::ordered_json ToJson(const ChartPoint& point);

/// The columns of ToJson as CSV: `header` lines after '#', the names, a row a point.
std::string ChartCsv(const std::vector<ChartPoint>& points, const std::vector<std::string>& header);

/// The points that no other point beats in both time and error, from fast to slow: indices. Points
/// without time, that did not converge or whose error is not finite take no part.
std::vector<std::size_t> ParetoFront(const std::vector<ChartPoint>& points);

/// The point of least error whose step takes at most `budget_us`, or nullptr.
const ChartPoint* BestWithin(const std::vector<ChartPoint>& points, double budget_us);

/// In words: "strain, quadratic B-spline 6^3, n 335".
std::string Describe(const ChartPoint& point);

}  // namespace hpdm
