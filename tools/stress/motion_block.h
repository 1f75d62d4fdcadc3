#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/stress/stress_case.h"
#include "tools/stress/stress_session_fixture.h"

/// The body that contacts and motions are tried on: a cube of soft tissue of 100 mm, held in its
/// lower quarter (E 5 kPa, Poisson's ratio 0.45).
namespace hpdm {

inline constexpr double kBlockThickness = 0.1;  ///< m; the top is at z = 0.
/// s: the hands wait until their forces are on.
inline constexpr double kBlockStart = 0.6;

/// `quick`: 3 cells an axis, not 4.
OrganOptions BlockOrgan(StressModel model, bool quick);
/// Faces outwards, edges of 5 mm (quick: 7 mm).
SurfaceMesh BlockSurface(bool quick);
/// All models but the tetrahedra; those on a lattice alone.
std::vector<StressModel> BlockModels();
std::vector<StressModel> LatticeModels();

/// A pose `x` beside the middle of the top and `z` above it, m.
StressPose AtBlock(double x, double z, double jaw = 1, double roll = 0);
/// A grasper of 5 mm that goes through `waypoints`, its trocar above the block.
StressTool BlockHand(std::vector<std::pair<double, StressPose>> waypoints, double x_trocar = 0.02);
/// A grasper that closes on the top at `x`, goes to `far` in `seconds` from kBlockStart on (0:
/// within one tick), opens at `released` and is away.
StressTool BlockGrasp(double x, const StressPose& far, double seconds, double released,
                      double x_trocar = 0.02);
/// A ball of 20 mm radius that goes `depth` (m) deep in `seconds` from kBlockStart on, and is away
/// at `released`.
StressTool BlockBall(double depth, double seconds, double released);

/// What came of a motion that ends at `released` (s): runs the body to a second after that.
///
/// The error is of the tissue's volume while it is held, over that at rest. The fate is its own
/// (kVolumeDegraded, kVolumeFailed) but at least degraded where tissue was shown inside out or did
/// not follow its tools, and failed where any vertex stays 0.1 mm from rest.
StressTrial JudgeMotion(StressSessionFixture* body, double released);
inline constexpr double kVolumeDegraded = 0.1;
inline constexpr double kVolumeFailed = 0.5;
/// In words, for StressCase::truth.
extern const char* const kVolumeTruth;

/// Whether the body is back, and what was seen of it, as JudgeMotion has it; for a trial whose
/// error is another. Raises its fate and sets how and harm.
void AddReturn(StressSessionFixture* body, double released, StressTrial* trial);

/// Of the organ's vertices from rest, V x 3, m.
Points Displacements(const StressSessionFixture& body);

}  // namespace hpdm
