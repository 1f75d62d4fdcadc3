#pragma once

#include <string>
#include <vector>

#include "engine/organ.h"
#include "haptics/device/impulse_engine.h"

namespace hpdm {

/// The virtual wall that renders rigid organs to one instrument: a stiffness that its device
/// displays stably, the same everywhere and in every direction.
struct VirtualWall {
  double stiffness = 0;             ///< N/m: half of the limit, a gain margin of two.
  double limit = 0;                 ///< N/m; the wall is stable below it.
  int axis = 0;                     ///< Axis of the limit: kPitch, kYaw or kInsertion.
  Vector3d p_W = Vector3d::Zero();  ///< Place of the limit on an organ, m.
  double lever = 0;                 ///< From the trocar to the tip at that place, m.
  bool reachable = false;           ///< False: the tip reaches no rigid organ; p_W is its farthest
                                    ///< point.
};

/// Finds the wall of one instrument at the rigid organs among `organs`.
///
/// 1. Axis i of the device alone is stable up to the stiffness K_i (StabilityLimit(), exact in
///    discrete time for the hold over `period` in s and the profile's delay). At the tip this is
///    K_i / g_i, with g_i the squared length of column i of the Jacobian J.
/// 2. The columns of J are orthogonal. A wall of stiffness k and normal n couples them by
///    k J^T n n^T J. All three axes are stable while
///        k sum_i n_i^2 g_i / K_i < 1.
///    This is exact where damping dominates (K_i near 2 b_i / (T + 2 delay)): the condition then
///    says that B - k (T/2 + delay) J^T n n^T J is positive.
/// 3. For every n, and for a contact that friction holds in every direction, the condition is
///        k < min_i K_i / g_i.
/// 4. The limit is the smallest such value over the vertices that the tip reaches with a straight
///    shaft past all organs at rest, and over where the organ's own motion takes them. It falls
///    with the square of the lever.
///
/// One stiffness for all directions keeps the force at k x depth along the normal on the whole
/// organ. With a stiffness per axis the wall would be a few times harder along the shaft, but
/// friction would pull it sideways, and a slide would feel the device instead of the organ.
///
/// Set-up. Throws InputError if the device has no damping and an organ has no wall_stiffness.
VirtualWall FindVirtualWall(const std::vector<OrganModel>& organs,
                            const InstrumentOptions& instrument,
                            const ImpulseEngineKinematics& kinematics, double period);

/// Returns a line for each organ whose own wall_stiffness exceeds the limit.
std::vector<std::string> WallRemarks(const std::vector<OrganModel>& organs,
                                     const std::string& instrument, const VirtualWall& wall);

}  // namespace hpdm
