#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/shared/timing.h"

namespace hpdm {

/// Result of one model on one load case: distance from the reference solution and time of a step.
struct ChartPoint {
  std::string load_case;
  bool hollow = false;
  std::string model;   ///< hpdm, continuum, mass_spring, linear_tetrahedra, linear_graded,
                       ///< quadratic_graded.
  std::string energy;  ///< strain or metric; empty without a lattice.
  std::string strain;  ///< small or finite; metric: the domain, organ or box.
  std::string basis;
  std::string solver;
  int degree = 0;
  std::array<int, 3> cells = {0, 0, 0};  ///< Along each axis.
  int unknowns = 0;                      ///< Control points, vertices or nodes.
  int local_functions = 0;
  int local_refinement = 0;
  int adaptive_levels = 0;  ///< Finer levels; 0: a uniform lattice.

  double error = 0;                        ///< Area-weighted relative L2 against the reference
                                           ///< solution.
  std::optional<double> compliance_ratio;  ///< Divided by the reference solution's; absent if
                                           ///< fitted.
  bool fitted = false;            ///< No modulus in pascals: pressed to the depth of least error.
  std::optional<int> iterations;  ///< In one step.
  std::optional<double> residual;
  bool converged = true;  ///< The step within its budget, the load within its tolerance.

  std::optional<double> setup_ms;
  std::optional<Timing> response;        ///< Reposition and relax.
  std::optional<Timing> relocation;      ///< The case's own vertices.
  std::optional<Timing> relocation_30k;  ///< 15,000 vertices: a surface of 30,000 triangles.

  /// Returns the time that a step is charged with: response and the relocation of 30,000 triangles.
  /// The surface models move their vertices in the response. Returns infinity without times.
  double StepMicroseconds() const;
  double StepMinimumMicroseconds() const;
};

/// Returns all fields in the order of the columns; null where one is absent. Keys are stable:
/// scripts read them.
nlohmann::ordered_json ToJson(const ChartPoint& point);

/// Returns the columns of ToJson as CSV: `header` lines after '#', the names, one row per point.
std::string ChartCsv(const std::vector<ChartPoint>& points, const std::vector<std::string>& header);

/// Returns the indices of the points that no other point beats in both time and error, from fast to
/// slow. Points without time, without convergence or with an error that is not finite are left out.
std::vector<std::size_t> ParetoFront(const std::vector<ChartPoint>& points);

/// Returns the point of least error whose step takes at most `budget_us`, or nullptr.
const ChartPoint* BestWithin(const std::vector<ChartPoint>& points, double budget_us);

/// Describes the model: "strain, quadratic B-spline 6^3, n 335".
std::string Describe(const ChartPoint& point);

}  // namespace hpdm
