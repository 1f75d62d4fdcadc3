#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/organ.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/safety/stability.h"

namespace hpdm {

/// Where an organ is stiffest for an axis of an instrument's device, against what that displays.
struct StiffestContact {
  double stiffness = 0;  ///< N/m at the tip, along the direction in which the axis moves it.
  StiffnessLimit limit;  ///< N/m, likewise.
  int axis = 0;          ///< kPitch, kYaw or kInsertion.
  Vector3d p_W = Vector3d::Zero();  ///< On the rest surface, m.
  double Ratio() const { return stiffness / limit.Least(); }
};

/// How stiff each vertex of the organ is to a tip that presses it along its normal, N/m: V.
/// Reaction "lattice": 1 / (n^T C n) with the compliance at rest of lattice and indentation
/// (half_space.h) under a tip of the given radius; local functions would make it softer by a
/// little, so it is a bound. Not of a rigid organ (virtual_wall.h). Otherwise, and in an organ
/// without a compliance, k1 + sum k2 of the vertex' neighbours. Set-up: factorises the organ's
/// stiffness unless it has local functions.
Eigen::VectorXd ContactStiffness(const OrganModel& organ, const InstrumentOptions& instrument);

/// The greatest ratio of stiffness to limit over the vertices that the tip reaches: inside the
/// device's workspace, on the side that faces the trocar. A contact of stiffness k and normal n
/// stands in the way of axis i as k (c_i . n)^2, c_i the axis' direction at the tip. Nothing when
/// it reaches none. `delay`: s, beyond the hold.
std::optional<StiffestContact> FindStiffestContact(const OrganModel& organ,
                                                   const InstrumentOptions& instrument,
                                                   const ImpulseEngineKinematics& kinematics,
                                                   double period, double delay);

/// A remark for the user where the limit is exceeded, one line; else empty.
std::string StiffnessRemark(const std::string& instrument, const std::string& organ,
                            const StiffestContact& contact);

const char* AxisName(int axis);

}  // namespace hpdm
