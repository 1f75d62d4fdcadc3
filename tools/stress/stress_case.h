#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/organ_options.h"

/// Cases in which methods of this kind are known to fail (`hpdm stress`).
namespace hpdm {

/// Models that a case runs on: ours and those for comparison.
enum class StressModel {
  kStrainSmall,       ///< Energy "strain", small strain.
  kStrainFinite,      ///< Energy "strain", finite strain.
  kMetricSmall,       ///< The paper's energy.
  kMetricFinite,      ///< The paper's energy, nonlinear.
  kContinuum,         ///< Surface continuum.
  kMassSpring,        ///< Springs on the surface, explicit Euler.
  kLinearTetrahedra,  ///< About 4,000 nodes, offline.
  kPointProxy,        ///< A proxy on the last step's triangles (point_proxy.h), without tissue.
};
inline constexpr int kStressModels = 8;

/// Returns the stable name: "strain_small", "mass_spring".
std::string Name(StressModel model);
/// Returns the name for tables: "strain, small", "mass-spring".
std::string Title(StressModel model);
/// True for the models on the project's own lattice, which nothing may harm.
bool IsOurs(StressModel model);
/// Sets energy and strain, or the surface model; the rest of `options` stays. Not for tetrahedra
/// and point proxy.
void Choose(StressModel model, OrganOptions* options);

/// Rounds a parameter that is a count.
inline int Whole(double parameter) { return static_cast<int>(std::lround(parameter)); }

enum class StressFate { kSurvived, kDegraded, kFailed };

/// Outcome of one run of a case, without its time.
struct StressTrial {
  StressFate fate = StressFate::kSurvived;
  std::optional<double>
      error;        ///< Relative (0..1), against the case's truth; absent if not measured.
  std::string how;  ///< A few words for a table: "18 mm dent stays"; may be empty.
  /// A fault that no input may cause (Harm() in stress_session_fixture.h: NaN, a force that the
  /// organ does not have, lasting damage), in a few words. Empty if there is none.
  std::string harm;
};

/// Returns survived below `degraded_from`, and failed from `failed_from` or if `error` is not
/// finite.
StressTrial Judge(double error, double degraded_from, double failed_from);

/// Parameter that a case raises until a model fails. Every model should bear `easy`. The fate is
/// reported at `asked`. The search ends at `utmost`. May descend.
struct StressParameter {
  std::string name;  ///< "lift".
  std::string unit;  ///< Unit of the values: "mm".
  double easy = 0;
  double asked = 0;
  double utmost = 0;
  bool logarithmic = false;  ///< Bisected by ratio; all three are positive.
};

struct StressCase {
  std::string name;   ///< Stable: "grasp_through_itself".
  std::string group;  ///< "material", "contact", "motion", "haptics", "touch", "organs" or
                      ///< "parts".
  std::string title;  ///< One line: the body and its treatment.
  std::string
      truth;  ///< Reference of the error, and the limits from which it counts as degraded and
              ///< failed.
  StressParameter parameter;
  std::vector<StressModel> models;
  /// Runs a model at a value of the parameter. Single-threaded, repeatable.
  std::function<StressTrial(StressModel model, double value)> run;
};

/// Result of a model in a case.
struct StressResult {
  StressModel model = StressModel::kStrainSmall;
  StressTrial asked;                 ///< Trial at the parameter's `asked`.
  std::optional<double> holds_to;    ///< Largest value known not to fail; absent: fails at `easy`.
  std::optional<double> fails_from;  ///< First value known to fail; absent: holds to `utmost`.
  std::string fails_how;             ///< `how` of the trial at `fails_from`.
  std::string harm;  ///< First harm in any trial of one of our models, with the parameter's value.
  int trials = 0;
};

/// Runs the trial at `asked` and finds the boundary of failure by bisection of the values that
/// bracket it, in `rounds` halvings. An exception (InputError if the model cannot be built) counts
/// as a failure with its message.
StressResult Examine(const StressCase& stress_case, StressModel model, int rounds);

/// Returns the value at a share (0..1) of the range from `a` to `b`, on the parameter's scale.
double Between(const StressParameter& parameter, double a, double b, double share);

}  // namespace hpdm
