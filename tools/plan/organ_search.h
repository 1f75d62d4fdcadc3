#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/plan/organ_touches.h"
#include "tools/plan/plan_families.h"
#include "tools/plan/reference_solution.h"
#include "tools/shared/timing.h"

namespace hpdm {

/// One model of an organ, with its estimated error and its measured cost.
struct PlanPoint {
  std::string family;
  OrganOptions model;
  bool choosable = true;
  int control_points = 0;
  int local_functions = 0;      ///< Per contact, in use.
  std::vector<Points> answers;  ///< Solution of each case: V x 3, m.
  double distance = 0;          ///< Their distance from the reference solution: PooledError.
  double error = 0;             ///< Error estimate: the distance plus the reference solution's
                                ///< uncertainty.
  bool converged = true;        ///< Every step within its budget, and under the loads.
  std::vector<Timing> steps;    ///< [k]: reposition, relax, relocate with k + 1 contacts.
  double setup_ms = 0;          ///< CPU time of the thread.
  double Microseconds(std::size_t contacts) const { return steps[contacts - 1].median_us; }
  /// Returns the step time with the largest number of contacts.
  double MostMicroseconds() const { return steps.back().median_us; }
};

struct SearchOptions {
  double error = 0;        ///< Demanded relative L2 error.
  double budget_us = 0;    ///< Step time.
  double deadline_ms = 0;  ///< Search time of one organ; 0: unlimited.
  std::function<bool()> stopped = [] { return false; };  ///< True: the user ends the search.
};

/// Searches the families from quick to slow set-up, each from coarse to fine. A family ends when
/// one of these holds:
/// 1. It meets the error.
/// 2. Its steps cost more than those of the cheapest model that meets the error. If no model meets
///    it yet, the bound is four times the budget.
/// 3. Refining it no longer helps.
/// 4. Set-up takes ten seconds, or the deadline has passed, or the user ends the search.
///
/// Calls `progress` with every point.
std::vector<PlanPoint> SearchOrgan(const OrganOptions& organ, const SurfaceMesh& rest,
                                   const OrganTouches& touches,
                                   const ReferenceSolution& reference_solution,
                                   const SearchOptions& options,
                                   const std::function<void(const PlanPoint&)>& progress,
                                   std::vector<std::string>* remarks);

/// Measures a model. Throws InputError if it cannot be built.
PlanPoint MeasureModel(const PlanFamily& family, const OrganOptions& model, const SurfaceMesh& rest,
                       const OrganTouches& touches, const ReferenceSolution& reference_solution);

/// Returns the indices of the choosable points that no other beats in both error and time, from
/// fast to slow.
std::vector<std::size_t> PlanFront(const std::vector<PlanPoint>& points);

/// Returns the cheapest point of at most this error.
std::optional<std::size_t> CheapestWithin(const std::vector<PlanPoint>& points, double error);

}  // namespace hpdm
