#pragma once

#include <array>
#include <vector>

#include "engine/contact/contact_constraints.h"
#include "engine/contact/contact_solver.h"

namespace hpdm {

/// The sparse m x n contact rows over the vertices. The non-zero weights are gathered once per
/// step, so later products cost only the contacts' own vertices.
class ContactRows {
 public:
  struct Entry {
    int vertex = 0;
    double weight = 0;
  };

  /// `n`: number of the organ's vertices.
  explicit ContactRows(Eigen::Index n);

  void Gather(const ContactConstraints& contacts);
  int size() const { return size_; }
  const Entry* begin(int row) const { return entries_.data() + first_[row]; }
  const Entry* end(int row) const { return entries_.data() + first_[row + 1]; }

  /// Weighted sum of `values` (n x 3) over a row's vertices.
  Vector3d Sum(int row, const Points& values) const;

 private:
  int size_ = 0;
  std::array<std::size_t, kMaxContacts + 1> first_{};
  std::vector<Entry> entries_;
};

/// A, m x m, m/N: one number per pair of contact rows, the same for x, y and z.
using ContactCompliance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                        kMaxContacts, kMaxContacts>;
using ContactPoints = std::array<Vector3d, kMaxContacts>;

/// Finds the forces f with which the contact points x = p_free + A f satisfy the contacts
/// (contact_constraints.h), and writes them into the rows. `compliance`: A, symmetric with a
/// positive diagonal. `p_free_W`: the m contact points without contact forces, m. `targets_W`
/// replaces the rows' targets, m. `contact_solver` is working memory. Deformation thread; allocates
/// nothing.
RelaxationResult SolveContactForces(const ContactCompliance& compliance,
                                    const ContactPoints& p_free_W, const ContactPoints& targets_W,
                                    ContactSolver* contact_solver, ContactConstraints* contacts);

}  // namespace hpdm
