#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/organ_options.h"

/// Cases in which methods of this kind are known to break (`hpdm stress`).
namespace hpdm {

/// What a case is run on: ours, and what it is compared with.
enum class StressModel {
  kStrainSmall,       ///< Energy "strain", small strain.
  kStrainFinite,      ///< The same, finite strain.
  kMetricSmall,       ///< The paper's energy.
  kMetricFinite,      ///< The same, nonlinear.
  kContinuum,         ///< Surface continuum.
  kMassSpring,        ///< Springs on the surface, explicit Euler.
  kLinearTetrahedra,  ///< Of about 4,000 nodes, offline.
  kPointProxy,        ///< A proxy on the last step's triangles (point_proxy.h): no tissue.
};
inline constexpr int kStressModels = 8;

/// Stable: "strain_small", "mass_spring".
std::string Name(StressModel model);
/// For people: "strain, small", "mass-spring".
std::string Title(StressModel model);
/// Of the project's own lattice, which nothing may harm.
bool IsOurs(StressModel model);
/// Sets energy and strain, or the surface model; the rest of `options` stays. Not for tetrahedra
/// and point proxy.
void Choose(StressModel model, OrganOptions* options);

/// A parameter that is a number of things.
inline int Whole(double parameter) { return static_cast<int>(std::lround(parameter)); }

enum class StressFate { kSurvived, kDegraded, kFailed };

/// One run of a case: how it went, not how long it took.
struct StressTrial {
  StressFate fate = StressFate::kSurvived;
  std::optional<double>
      error;        ///< Relative (0..1), against the case's truth; absent: not measured.
  std::string how;  ///< A few words for a table: "18 mm dent stays"; empty: nothing to say.
  /// What no input may do (NaN, a force or its change beyond the guard's limits, lasting damage),
  /// in a few words; empty: none.
  std::string harm;
};

/// Survived below `degraded_from`, failed from `failed_from` on or where `error` is not finite.
StressTrial Judge(double error, double degraded_from, double failed_from);

/// What a case raises until a model fails, from `easy`, which every model should bear, over
/// `asked`, where its fate is told, to `utmost`, beyond which nobody goes. May descend.
struct StressParameter {
  std::string name;  ///< "lift".
  std::string unit;  ///< Of display, as the values are: "mm".
  double easy = 0;
  double asked = 0;
  double utmost = 0;
  bool logarithmic = false;  ///< Halved in ratio; all three positive.
};

struct StressCase {
  std::string name;   ///< Stable: "grasp_through_itself".
  std::string group;  ///< "material", "contact", "motion" or "haptics".
  std::string title;  ///< A line for people, what is done to what.
  std::string
      truth;  ///< What the error is against, and from where it counts as degraded and failed.
  StressParameter parameter;
  std::vector<StressModel> models;
  /// At a value of the parameter. Single-threaded, repeatable.
  std::function<StressTrial(StressModel model, double value)> run;
};

/// Where a model stands in a case.
struct StressResult {
  StressModel model = StressModel::kStrainSmall;
  StressTrial asked;                 ///< At the parameter's `asked`.
  std::optional<double> holds_to;    ///< The last value known not to fail; absent: fails when easy.
  std::optional<double> fails_from;  ///< The first known to fail; absent: holds to the utmost.
  std::string fails_how;             ///< At `fails_from`.
  std::string harm;  ///< First of any trial of a model of ours, with the parameter's value.
  int trials = 0;
};

/// The trial asked for, and the boundary of failure by bisection between the values that bracket
/// it: until they are `rounds` halvings close. An exception (InputError of a model that refuses to
/// be built) is a failure that says why.
StressResult Examine(const StressCase& stress_case, StressModel model, int rounds);

/// The value a share (0..1) of the way from `a` to `b`, on the parameter's scale.
double Between(const StressParameter& parameter, double a, double b, double share);

}  // namespace hpdm
