#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/collision.h"
#include "tools/stress/stress_case.h"
#include "tools/stress/stress_session_fixture.h"

/// One organ and one tool that touches it, for the cases about felt forces.
namespace hpdm {

/// Returns a surface of 20 frequency^2 nearly equal triangles with the half-axes `radii` (m),
/// outward. An icosahedron's faces are split in frequency^2 and pushed out to the ellipsoid.
/// frequency >= 1.
SurfaceMesh GeodesicEllipsoid(const Vector3d& radii, int frequency);

/// Returns the same around a cavity with both walls meshed; `wall`: thickness along the axes, m.
SurfaceMesh HollowEllipsoid(const Vector3d& radii, double wall, int frequency);

struct StressTouchFixture {
  StressModel model = StressModel::kStrainSmall;
  OrganOptions organ;
  SurfaceMesh rest;
  TimingOptions timing = {};

  /// Returns the outermost point of the surface over (x, y), m, which must exist.
  Vector3d Top(double x, double y) const;
  /// Returns the same, using a tree of `rest` for repeated calls.
  Vector3d Top(const SurfaceTree& surface, double x, double y) const;
};

/// Returns the depth of a sphere in a surface, m; negative outside.
double Depth(const SurfaceTree& surface, const Vector3d& p_centre_W, double radius);

/// Returns a soft ellipsoid with half-axes 0.1 x 0.07 x 0.05 m, supported at its lower quarter.
StressTouchFixture SoftOrgan(StressModel model, bool quick);

/// Returns a hollow ellipsoid with half-axes 0.05 x 0.04 x 0.04 m and a wall of 3 mm.
StressTouchFixture HollowOrgan(StressModel model, bool quick);

/// Returns the pose on the vertical through a surface point with the tip `depth` (m) below
/// `p_top_W`; negative above.
StressPose Below(const Vector3d& p_top_W, double depth, const StressTool& tool = {});

/// Returns a tool that hangs over the organ and moves along `way`.
StressTool OverOrgan(std::vector<std::pair<double, StressPose>> way);

inline constexpr double kRampedIn = 0.55;  ///< s: end of the guard's start-up.

/// A motion: into the organ, back and forth along x at one height, and out again.
struct PressAndSlide {
  double depth = 0.008;  ///< m, at the entry.
  double length = 0.02;  ///< m, length of the slide.
  double speed = 0.05;   ///< m/s.
  double slides = 0;     ///< s, set by Tool(): start of the slide.
  double ends = 0;       ///< s: end of the slide.
  double leaves = 0;     ///< s: tip leaves the surface.
  double out = 0;        ///< s: tip is 10 mm above the organ.

  /// Returns the tool `held` in this motion over `p_top_W`.
  StressTool Tool(const Vector3d& p_top_W, const StressTool& held = {});
};

using FeltTimeSeries = std::vector<ToolSample>;  ///< One sample a tick, from the first.

/// The force that the hand feels until `seconds`, and the organ's outcome. A point proxy has no
/// tissue, so it has forces only.
struct FeltTouch {
  FeltTimeSeries series;
  StressOutcome outcome;
};
FeltTouch Feel(const StressTouchFixture& fixture, const StressTool& tool, double seconds);

/// The force series of each model, kept because they do not depend on the case's parameter.
using KeptTimeSeries = std::shared_ptr<std::map<StressModel, FeltTimeSeries>>;
inline KeptTimeSeries Keep() { return std::make_shared<KeptTimeSeries::element_type>(); }
const FeltTimeSeries& Kept(const KeptTimeSeries& kept, StressModel model,
                           const std::function<FeltTimeSeries()>& make);

/// Returns the mean reaction (the force before the guard), N, over the ticks of [from, to) s, at 1
/// kHz.
Vector3d MeanForce(const FeltTimeSeries& series, double from, double to);

/// Returns the settled reaction, N, after a slow motion (0.1 m/s) from `from` to `to`.
Vector3d ForceGoneToSlowly(const StressTouchFixture& fixture, StressTool tool,
                           const StressPose& from, const StressPose& to);

/// Returns ContactError (force_signal.h) of the reactions from `from` s. Both series must
/// have the same length.
double FeltError(const FeltTimeSeries& series, const FeltTimeSeries& truth, double from);

/// Returns |a - truth| / |truth|.
double RelativeError(const Vector3d& a, const Vector3d& truth);

/// Marks the trial as failed for the reason `how`, unless it already has a reason.
void Fail(const std::string& how, StressTrial* trial);

/// Returns the time, s, after which tissue must be at rest; the surface models need more.
inline double ToRest(StressModel model) { return IsOurs(model) ? 0.35 : 1.2; }

/// Gives a trial that did not survive the measured and the intended force (N) as its reason, unless
/// it already has a reason.
void ReportForces(double force, double meant, StressTrial* trial);

/// Judges the trial, and fails it if Harm() finds something. For the surface models only the end
/// counts.
StressTrial JudgeTouch(StressModel model, double error, double degraded_from, double failed_from,
                       const StressOutcome& outcome, double released);

}  // namespace hpdm
