#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/base/copying.h"
#include "engine/base/work_array.h"
#include "engine/contact/contact_solver.h"

namespace hpdm {

/// The contact rows of one organ with a dense K^-1 (3n x 3n). A step reads only two parts of K^-1. The
/// entries between the control points that the rows touch give the compliance between the rows,
/// B K^-1 B^T. The columns of those points, read once, give the displacements under all forces.
/// Weights beyond n are of local functions and do not count. Deformation thread; allocates nothing.
class RowResponses {
 public:
  /// `inverse` must outlive it.
  explicit RowResponses(const Eigen::MatrixXd& inverse);

  /// Takes the rows of a step.
  void Gather(const ContactConstraints& contacts);
  /// Adds yield B K^-1 B^T to the problem, in which the organ is number `body`.
  void AddCompliance(int body, double yield, ContactSolver* solver);

  /// Takes the forces that `solver` found on the rows.
  void SetForces(int body, const ContactSolver& solver);
  /// Sets u (3n, m) to K^-1 B^T f.
  void Deform(Eigen::Ref<Eigen::VectorXd> u) const;

  /// A weight of a row.
  struct Entry {
    int point;  ///< Control point.
    int place;  ///< Of that among the touched ones.
    double weight;
  };
  std::span<const Entry> EntriesOf(int row) const {
    const auto i = static_cast<std::size_t>(row);
    return {entries_.data() + i * static_cast<std::size_t>(n_), entry_count_[i]};
  }

 private:
  // Touched control points with successive numbers.
  struct Run {
    int first = 0;  // control point
    int place = 0;
    int length = 0;
  };
  void MoveRows();
  void FillRowCompliance();

  const Eigen::MatrixXd* inverse_;
  int n_;
  int row_count_ = 0;
  int count_ = 0;              // number of control points that the rows touch
  std::vector<int> place_;     // n: of the control points in touched_, or -1
  std::vector<int> touched_;   // n; the first count_ are these control points
  std::size_t run_count_ = 0;  // of them
  std::vector<Run> runs_;      // n
  std::array<std::size_t, kMaxContacts> entry_count_{};
  WorkArray<Entry> entries_;  // kMaxContacts x n
  // Three columns of K^-1, of the touched control points: 3n x 3.
  Eigen::Matrix<double, Eigen::Dynamic, 3> column_;
  WorkMatrix moved_;  // of the touched points by unit forces on the rows: 3n x 3 kMaxContacts
  WorkMatrix row_compliance_;  // B K^-1 B^T of the last AddCompliance()
  Eigen::Matrix3Xd forces_;    // on the touched control points, N
};

}  // namespace hpdm
