#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Most contact rows that one organ has in one step: 16 a tool.
inline constexpr int kMaxContacts = 32;

/// Rows are contacts, columns control points: m x n, m <= kMaxContacts.
using ContactWeights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Moves the control points directly, so that the contacts move as asked (Eq. 26-28): adds to
/// `control_displacements` (n x 3, m) the change of least Euclidean norm that adds `contact_change`
/// (m x 3, m) to the contacts whose rows are `weights` (m x n):
///     dU = B^T (B B^T)^+ dx,
/// with the pseudo-inverse that drops eigenvalues below 1e-10 of the largest. (Eq. 8 and 28 print
/// (B^T B)^-1 B^T, which is singular for fewer contacts than control points; for one contact both
/// are Eq. 9.) Contacts that coincide and disagree get their mean. Returns the rank.
/// Deformation thread; allocates nothing.
int MoveDirectly(const Eigen::Ref<const ContactWeights>& weights,
                 const Eigen::Ref<const Points>& contact_change,
                 Eigen::Ref<Points> control_displacements);

}  // namespace hpdm
