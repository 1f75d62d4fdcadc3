#pragma once

#include <string>
#include <vector>

#include "engine/organ.h"
#include "engine/step/tip_press.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/safety/passivity.h"
#include "haptics/safety/wall_limit.h"

namespace hpdm {

/// The virtual walls that render rigid organs to one instrument: the stiffness that its device
/// displays at each place (WallLimits).
struct VirtualWall {
  /// Extremes of the stiffness along the normal, N/m, over the vertices of all rigid organs that
  /// the tip reaches with a straight shaft past all organs at rest.
  double least = 0, median = 0, greatest = 0;
  Vector3d p_least_W = Vector3d::Zero();  ///< Place of the least on an organ, m.
  double lever = 0;                       ///< From the trocar to the tip there, m.
  double limit = 0;        ///< N/m: least limit in every direction there; a wall above it vibrates.
  bool reachable = false;  ///< False: the tip reaches no rigid organ, and the figures are those of
                           ///< its farthest point, along the shaft.
  std::vector<WallField> fields;  ///< [organ]; no rows for those that deform.
};

/// Finds the walls of one instrument at the rigid organs among `organs`.
///
/// 1. Along the normal, a vertex has the stiffness WallLimit::Stiffness() of its own normal and of
///    its lever: half of what the device displays stably without a hand, with the passivity
///    controller and the profile's delay, and at most 2 f_c / encoder step.
/// 2. Across the normal, where friction holds the tip, it has the least such stiffness of all
///    directions.
/// 3. An organ that moves has at each vertex the lesser of its two extreme positions.
/// 4. The stiffness differs along the surface. The force is still k x depth along the normal, and
///    PassivityControl returns at most the energy that the hand has put in.
///
/// Set-up. Throws InputError if the device displays no wall, for lack of damping or friction, and
/// an organ has no wall_stiffness.
VirtualWall FindVirtualWall(const std::vector<OrganModel>& organs,
                            const InstrumentOptions& instrument,
                            const ImpulseEngineKinematics& kinematics, double period);

/// Returns a line for each organ whose own wall_stiffness exceeds the limit.
std::vector<std::string> WallRemarks(const std::vector<OrganModel>& organs,
                                     const std::string& instrument, const VirtualWall& wall);

/// Returns the passivity options of an instrument's device in a loop of `period` s.
PassivityOptions PassivityOf(const DeviceProfile& device, double period);

}  // namespace hpdm
