#pragma once

#include <algorithm>

#include "engine/organ/organ_state.h"

namespace hpdm {

/// Returns by how much (m) a tool's row demands that its lattice point move from its present place.
/// A press only pushes along its normal. Deformation thread.
inline Vector3d DemandedMove(const OrganState& state, int row) {
  const ContactConstraints::Row& contact = state.contacts[row];
  const Vector3d p = contact.p_rest_W +
                     (state.contacts.Weights().row(row) * state.control_displacements).transpose();
  const Vector3d move = contact.target_W - p;
  if (contact.kind != ContactConstraints::RowKind::kPress) return move;
  return std::min(0.0, contact.normal_W.dot(move)) * contact.normal_W;
}

/// Returns the longest such move, m.
inline double LongestDemandedMove(const OrganState& state) {
  double longest = 0;
  for (int row = 0; row < state.contacts.tool_rows(); ++row) {
    longest = std::max(longest, DemandedMove(state, row).norm());
  }
  return longest;
}

}  // namespace hpdm
