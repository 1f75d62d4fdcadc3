#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/organ.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/safety/stability.h"

namespace hpdm {

/// The contact that exceeds the limit of a device axis the most, or comes nearest to it.
struct StiffestContact {
  double stiffness = 0;  ///< N/m at the tip, along the direction in which the axis moves it.
  StiffnessLimit limit;  ///< N/m, in the same direction.
  int axis = 0;          ///< kPitch, kYaw or kInsertion.
  Vector3d p_W = Vector3d::Zero();  ///< Place on the rest surface, m.
  double greatest = 0;  ///< Greatest stiffness along the normal of all contacts in reach, N/m.
  /// 0 without a stiffness; infinite if the axis displays none, as without damping.
  double Ratio() const { return stiffness > 0 ? stiffness / limit.Least() : 0; }
};

/// Returns the stiffness of each vertex to a tip that presses along its normal, N/m (V values).
///
///     reaction "lattice":           1 / (n^T C n); of viscoelastic tissue the instantaneous one
///     otherwise, or without a C:    k1 + sum of k2 over the vertex's neighbours
///
/// C is the compliance at rest of lattice and indentation (half_space.h) under a tip of the given
/// radius. The result is an upper bound: local functions make the organ slightly softer. `organ` is
/// not rigid (virtual_wall.h). Set-up: factorises the organ's stiffness unless it has local
/// functions.
Eigen::VectorXd ContactStiffness(const OrganModel& organ, const InstrumentOptions& instrument);

/// Returns the compliance (m/N) of a press on an elastic organ when it is deep: as under a load with
/// the kernel of the tip's radius. The patch's own compliance is that of a ball at the step's force.
Matrix3d DeepCompliance(const ToolPatch& patch);

/// Finds the contact with the largest ratio of stiffness to limit, and of equal ones the stiffest,
/// over the vertices that the tip can reach: those in the device's workspace, on the side that
/// faces the trocar. A contact of stiffness k and normal n resists axis i with the stiffness
/// k (c_i . n)^2, where c_i is the axis' direction at the tip. Returns nothing if the tip reaches no
/// vertex. `delay`: s, in addition to the hold.
std::optional<StiffestContact> FindStiffestContact(const OrganModel& organ,
                                                   const InstrumentOptions& instrument,
                                                   const ImpulseEngineKinematics& kinematics,
                                                   double period, double delay);

/// Returns one line for the user if the limit is exceeded, else an empty string.
std::string StiffnessRemark(const std::string& instrument, const std::string& organ,
                            const StiffestContact& contact);

/// Returns one line for the user if even the stiffest contact in reach gives less than 0.05 N at a
/// depth of 10 mm, which a hand hardly feels, else an empty string.
std::string FaintRemark(const std::string& instrument, const std::string& organ,
                        const StiffestContact& contact);

/// Returns one line for the user for friction in the trocar that the device cannot display
/// (TrocarFriction), since it has no damping or no friction of its own, else an empty string.
/// `period`: of the haptic loop, s.
std::string TrocarRemark(const InstrumentOptions& instrument, double period);

const char* AxisName(int axis);

}  // namespace hpdm
