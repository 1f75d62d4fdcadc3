#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/stress/stress_case.h"
#include "tools/stress/stress_session_fixture.h"

/// The body of the contact and motion cases: a 100 mm cube of soft tissue (E 5 kPa, Poisson's ratio
/// 0.45) whose lower quarter is held.
namespace hpdm {

inline constexpr double kBlockThickness = 0.1;  ///< m; the top is at z = 0.
/// s: the hands start when their forces are on.
inline constexpr double kBlockStart = 0.6;

/// Returns the block's options; `quick`: 3 cells an axis instead of 4.
OrganOptions BlockOrgan(StressModel model, bool quick);
/// Returns the block's surface, outward, with edges of 5 mm (quick: 7 mm).
SurfaceMesh BlockSurface(bool quick);
/// All models but the tetrahedra, and those on a lattice only.
std::vector<StressModel> BlockModels();
std::vector<StressModel> LatticeModels();

/// Returns a pose `x` beside the middle of the top and `z` above it, m.
StressPose AtBlock(double x, double z, double jaw = 1, double roll = 0);
/// Returns a grasper of 5 mm that follows `waypoints`; its trocar is above the block.
StressTool BlockHand(std::vector<std::pair<double, StressPose>> waypoints, double x_trocar = 0.02);
/// Returns a grasper that closes on the top at `x`, moves to `far` in `seconds` from kBlockStart
/// (0: within one tick), opens at `released` and leaves.
StressTool BlockGrasp(double x, const StressPose& far, double seconds, double released,
                      double x_trocar = 0.02);
/// Returns a ball of 20 mm radius that moves `depth` (m) deep in `seconds` from kBlockStart and has
/// left at `released`.
StressTool BlockBall(double depth, double seconds, double released);

/// Runs the body to a second after `released` (s), the end of the motion, and judges it.
///
/// The error is the change of the tissue's volume while it is held, over that at rest.
/// kVolumeDegraded and kVolumeFailed apply to it. The trial is at least degraded if tissue was
/// shown inverted or did not follow its tools. It failed if any vertex stays 0.1 mm from rest.
StressTrial JudgeMotion(StressSessionFixture* body, double released);
inline constexpr double kVolumeDegraded = 0.1;
inline constexpr double kVolumeFailed = 0.5;
/// The text for StressCase::truth.
extern const char* const kVolumeTruth;

/// Checks whether the body is back at rest and how it looked, as JudgeMotion does, for a trial with
/// another error. Raises its fate and sets how and harm.
void AddReturn(StressSessionFixture* body, double released, StressTrial* trial);

/// Returns the displacements of the block's surface (V x 3, m) by quadratic tetrahedra in small
/// strain, if the points `held` (H x 3, m, at rest) are moved by `ways` (H x 3, m).
Points HeldBlock(const OrganOptions& organ, bool quick, const Points& held, const Points& ways);

/// Returns the displacements of the organ's vertices from rest, V x 3, m.
Points Displacements(const StressSessionFixture& body);

}  // namespace hpdm
