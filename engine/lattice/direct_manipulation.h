#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Most contact rows of one organ in one step.
inline constexpr int kMaxContacts = 128;
/// Most rows of tools among them: 16 for each tool.
inline constexpr int kMaxToolRows = 32;

/// Rows are contacts, columns control points: m x n, m <= kMaxContacts.
using ContactWeights = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Moves the control points so that the contacts move by `contact_change` (m x 3, m) (Eq. 26-28).
/// Adds to `control_displacements` (n x 3, m) the change of least Euclidean norm
///     dU = B^T (B B^T)^+ dx
/// with B = `weights` (m x n, m <= kMaxToolRows), the contacts' basis rows, and dx = `contact_change`.
///
/// 1. The pseudo-inverse drops eigenvalues below 1e-10 of the largest. Returns the rank.
/// 2. Contacts that coincide and contradict each other move by their mean.
/// 3. Eq. 8 and 28 print (B^T B)^-1 B^T, which is singular for fewer contacts than control points
///    (engine/README.md, section 3). For one contact the result is Eq. 9.
///
/// Deformation thread; allocates nothing.
int MoveDirectly(const Eigen::Ref<const ContactWeights>& weights,
                 const Eigen::Ref<const Points>& contact_change,
                 Eigen::Ref<Points> control_displacements);

}  // namespace hpdm
