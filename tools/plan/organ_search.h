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

/// One model of an organ: its error as estimated and its cost as measured.
struct PlanPoint {
  std::string family;
  OrganOptions model;
  bool choosable = true;
  int control_points = 0;
  int local_functions = 0;      ///< A contact, in use.
  std::vector<Points> answers;  ///< To each case: V x 3, m.
  double distance = 0;          ///< Theirs from the reference solution: PooledError.
  double error = 0;             ///< The estimate: with what the reference solution leaves in doubt.
  bool converged = true;        ///< Within a step's budget, and under the loads.
  std::vector<Timing> steps;    ///< [k]: reposition, relax, relocate with k + 1 contacts.
  double setup_ms = 0;          ///< Of the thread's own time.
  double Microseconds(std::size_t contacts) const { return steps[contacts - 1].median_us; }
  /// With as many contacts as there may be.
  double MostMicroseconds() const { return steps.back().median_us; }
};

struct SearchOptions {
  double error = 0;        ///< Asked for, relative L2.
  double budget_us = 0;    ///< Of a step.
  double deadline_ms = 0;  ///< For the search of one organ; 0: none.
};

/// Searches the families, those that are set up quickly first, each from coarse to fine. A family
/// ends when it meets the error, when its steps cost more than the cheapest model that meets it
/// (or, without one, than four times the budget), when refining it no longer helps, when set-up
/// takes ten seconds, and at the deadline. `progress` is told of every point.
std::vector<PlanPoint> SearchOrgan(const OrganOptions& organ, const SurfaceMesh& rest,
                                   const OrganTouches& touches,
                                   const ReferenceSolution& reference_solution,
                                   const SearchOptions& options,
                                   const std::function<void(const PlanPoint&)>& progress,
                                   std::vector<std::string>* remarks);

/// A model's figures. Throws InputError when it cannot be built.
PlanPoint MeasureModel(const PlanFamily& family, const OrganOptions& model, const SurfaceMesh& rest,
                       const OrganTouches& touches, const ReferenceSolution& reference_solution);

/// Of the points that may be chosen, those that none beats in both error and time: indices, from
/// fast to slow.
std::vector<std::size_t> PlanFront(const std::vector<PlanPoint>& points);

/// The cheapest point of at most this error.
std::optional<std::size_t> CheapestWithin(const std::vector<PlanPoint>& points, double error);

}  // namespace hpdm
