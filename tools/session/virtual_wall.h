#pragma once

#include <string>
#include <vector>

#include "engine/organ.h"
#include "haptics/device/impulse_engine.h"

namespace hpdm {

/// The virtual wall that rigid organs are to one instrument: as stiff as its device displays well,
/// the same everywhere and in every direction.
struct VirtualWall {
  double stiffness = 0;             ///< N/m: half of the limit, a gain margin of two.
  double limit = 0;                 ///< N/m, stable below.
  int axis = 0;                     ///< kPitch, kYaw or kInsertion, whose limit that is.
  Vector3d p_W = Vector3d::Zero();  ///< Where on an organ, m.
  double lever = 0;                 ///< From the trocar to the tip there, m.
  bool reachable = false;           ///< False: the tip reaches no rigid organ; p_W is its farthest.
};

/// The wall of one instrument at the rigid ones of `organs` (others are passed over).
///
/// Axis i of the device alone is stable up to K_i (StabilityLimit(): exact in discrete time, for
/// the hold over `period` in s and the profile's delay), which at the tip is K_i / g_i with g_i the
/// squared length of its column of J. The columns are orthogonal and a wall of stiffness k and
/// normal n couples them as k J^T n n^T J, so that all three are stable while
/// k sum n_i^2 g_i / K_i < 1: exactly so where damping rules (K_i near 2 b_i / (T + 2 delay)), for
/// then it says that B - k (T/2 + delay) J^T n n^T J is positive. For every n, and for a contact
/// that friction holds in every direction, that is k < min K_i / g_i. The limit is the least of it
/// over the vertices that the tip reaches, the shaft straight and past all organs at rest, and
/// where the organ's own motion takes them: the farther from the trocar, the softer, by the lever
/// squared.
///
/// One stiffness for all directions keeps the force at k x depth, along the normal, all over the
/// organ. With a stiffness for each axis the wall would be a few times harder along the shaft, but
/// friction would pull it askew and a slide would feel the device instead of the organ. Set-up.
/// Throws InputError when a device without damping meets an organ that has no stiffness of its own.
VirtualWall FindVirtualWall(const std::vector<OrganModel>& organs,
                            const InstrumentOptions& instrument,
                            const ImpulseEngineKinematics& kinematics, double period);

/// What is probably not meant, one line a piece: an organ's own wall_stiffness beyond the limit.
std::vector<std::string> WallRemarks(const std::vector<OrganModel>& organs,
                                     const std::string& instrument, const VirtualWall& wall);

}  // namespace hpdm
