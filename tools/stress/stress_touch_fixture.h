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

/// One organ and one tool that touches it, for the cases about what the hand feels.
namespace hpdm {

/// A surface of 20 frequency^2 nearly equal triangles with the half-axes `radii` (m), outwards: an
/// icosahedron's faces split in frequency^2, pushed out to the ellipsoid. frequency >= 1.
SurfaceMesh GeodesicEllipsoid(const Vector3d& radii, int frequency);

/// The same around a hollow, both walls meshed: `wall` (m) thick along the axes.
SurfaceMesh HollowEllipsoid(const Vector3d& radii, double wall, int frequency);

struct StressTouchFixture {
  StressModel model = StressModel::kStrainSmall;
  OrganOptions organ;
  SurfaceMesh rest;
  TimingOptions timing = {};

  /// The outermost point of the surface over (x, y), m. There must be one.
  Vector3d Top(double x, double y) const;
  /// The same with a tree of `rest`, for many.
  Vector3d Top(const SurfaceTree& surface, double x, double y) const;
};

/// How deep a sphere lies in a surface, m; negative: so far outside.
double Depth(const SurfaceTree& surface, const Vector3d& p_centre_W, double radius);

/// A soft ellipsoid of 0.1 x 0.07 x 0.05 m half-axes that rests on its lower quarter.
StressTouchFixture SoftOrgan(StressModel model, bool quick);

/// A hollow one of 0.05 x 0.04 x 0.04 m half-axes with a wall of 3 mm.
StressTouchFixture HollowOrgan(StressModel model, bool quick);

/// A way along the vertical through a point of the surface: a tool whose tip is `depth` (m) below
/// `p_top_W`, negative above.
StressPose Below(const Vector3d& p_top_W, double depth, const StressTool& tool = {});

/// A tool that hangs over the organ.
StressTool OverOrgan(std::vector<std::pair<double, StressPose>> way);

inline constexpr double kRampedIn = 0.55;  ///< s: the guard's start-up is over.

/// A way: into the organ, to and fro along x at one height, and out again.
struct PressAndSlide {
  double depth = 0.008;  ///< m, where it goes in.
  double length = 0.02;  ///< m, of the slide.
  double speed = 0.05;   ///< m/s.
  double slides = 0;     ///< s, set by Tool(): when it begins to slide,
  double ends = 0;       ///< is back,
  double leaves = 0;     ///< comes out of the surface,
  double out = 0;        ///< and 10 mm over the organ.

  /// The tool `held` on its way over `p_top_W`.
  StressTool Tool(const Vector3d& p_top_W, const StressTool& held = {});
};

using FeltTimeSeries = std::vector<ToolSample>;  ///< One a tick, from the first.

/// What the hand feels until `seconds`, and what became of the organ; of a point proxy, which has
/// no tissue, the forces alone.
struct FeltTouch {
  FeltTimeSeries series;
  StressOutcome outcome;
};
FeltTouch Feel(const StressTouchFixture& fixture, const StressTool& tool, double seconds);

/// What each model felt where the case's parameter plays no part: made once.
using KeptTimeSeries = std::shared_ptr<std::map<StressModel, FeltTimeSeries>>;
inline KeptTimeSeries Keep() { return std::make_shared<KeptTimeSeries::element_type>(); }
const FeltTimeSeries& Kept(const KeptTimeSeries& kept, StressModel model,
                           const std::function<FeltTimeSeries()>& make);

/// N: displayed on average over the ticks of [from, to) s, at 1 kHz.
Vector3d MeanForce(const FeltTimeSeries& series, double from, double to);

/// N: what the hand feels at the end of the way from `from` to `to`, gone slowly (0.1 m/s), when
/// all has settled.
Vector3d ForceGoneToSlowly(const StressTouchFixture& fixture, StressTool tool,
                           const StressPose& from, const StressPose& to);

/// ContactError (force_signal.h) of the displayed forces from `from` s on; of one length.
double FeltError(const FeltTimeSeries& series, const FeltTimeSeries& truth, double from);

/// |a - truth| / |truth|.
double RelativeError(const Vector3d& a, const Vector3d& truth);

/// The trial failed, for this reason if it had none yet.
void Fail(const std::string& how, StressTrial* trial);

/// s: as long is waited for the tissue to be back at rest; the surface models take their time.
inline double ToRest(StressModel model) { return IsOurs(model) ? 0.35 : 1.2; }

/// Says what was felt where it is not what was meant, if nothing else is said.
void ReportForces(double force, double meant, StressTrial* trial);

/// Judge(), and failed too where Harm() finds something, of the surface models at the end alone.
StressTrial JudgeTouch(StressModel model, double error, double degraded_from, double failed_from,
                       const StressOutcome& outcome, double released);

}  // namespace hpdm
