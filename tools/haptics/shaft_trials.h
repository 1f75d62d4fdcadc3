#pragma once

#include "tools/shared/felt_bench.h"

/// Trials of the shaft's contact: given poses, a step every 33 ticks, no device and no guard. The
/// tables of `hpdm haptics` (organ_tables.h), `hpdm stress` and the tests share them.
namespace hpdm {

inline constexpr double kLobeWall = 300;        ///< N/m, of the rigid lobe.
inline constexpr double kShaftToLobe = 0.15;    ///< m, from the trocar to the lobe, sideways.
inline constexpr double kShaftInserted = 0.25;  ///< m.
inline const Vector3d kShaftTrocar(-kShaftToLobe, 0, 0.02);

/// Returns the tool whose axis passes the height `z` (m) above the origin, moving down there at
/// `speed` (m/s).
ToolPose ShaftAcross(double z, double speed = 0);

OrganOptions RigidLobe();
/// A lobe of 5 kPa that stands on its support.
OrganOptions SoftLobe();

/// A shaft that sweeps down on a lobe around the origin.
struct ShaftSweep {
  double worst = 0;         ///< N, largest difference from the rigid lobe's wall.
  double largest_step = 0;  ///< N on the hand, between two ticks.
  double last = 0;          ///< N on the hand, at the end.
  double least_held = 0;    ///< N on the hand, the least after the first force: 0: passed through.
  int late = 0;             ///< Ticks from the touch to the first force.
};
/// The shaft starts 10 mm and the way of 0.1 s above the lobe's top, at the height `lobe_top` (m),
/// sweeps down to `depth` (m) and rests for 0.2 s.
ShaftSweep SweepShaftDown(FeltBench* bench, double lobe_top, double depth, double speed);

}  // namespace hpdm
