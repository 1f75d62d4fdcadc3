#pragma once

#include <array>
#include <vector>

#include "engine/base/check.h"
#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/snapshots.h"

namespace hpdm {

/// The tips that touch one organ, or are about to, each condensed to one point (engine/README.md,
/// section 4). A tip has m rows b_i: one of a press, or those of the grasped points, which jaws
/// move together. With C_rows = B K^-1 B^T + C_loc over the rows of all tips and T the identities
/// stacked per tip,
///     S = T^T C_rows^-1 T,   C = S^-1,   f = T^T (row forces),   p_original = x - C f:
/// where each tip's point x goes when all of them let go. Of a press, x is its row's point; of
/// jaws, the mean of theirs with the weights C_rows^-1 T C, which f turns about least. For presses
/// C = C_rows.
///
/// Sized once for the organ; a step fills it in place. Deformation thread; allocates nothing.
class TipCompliance {
 public:
  /// `n`: control points of the organ and slots for its local functions.
  explicit TipCompliance(int n);

  void Clear();
  /// Begins the next tip, which must get at least one row; its index, at most kMaxInstruments - 1.
  int AddTip();
  /// A row of the last tip, zero, to be filled in; its local compliance (m/N), where its point is
  /// now (m) and the force on the tissue there (N). Never more rows than ContactConstraints has,
  /// and one a tip beside it.
  auto AddRow(const Matrix3d& C_loc, const Vector3d& x_W, const Vector3d& force_W) {
    HPDM_CHECK(row_count_ < kMaxRows && tip_count_ > 0);
    rows_[row_count_] = {tip_count_ - 1, C_loc, x_W, force_W};
    weights_.row(row_count_).setZero();
    return weights_.row(row_count_++);
  }
  int size() const { return tip_count_; }

  /// A zero row for another point, and its entries that are not zero; until the next of either.
  auto ScratchRow() {
    weights_.row(kMaxRows).setZero();
    return weights_.row(kMaxRows);
  }
  SparseRow Compress(const Eigen::Ref<const Eigen::RowVectorXd>& row);

  /// Computes all that follows.
  void Condense(const LatticeCompliance& lattice);

  struct Tip {
    Vector3d x_W = Vector3d::Zero();           ///< m.
    Vector3d force_W = Vector3d::Zero();       ///< N, on the tissue.
    Vector3d p_original_W = Vector3d::Zero();  ///< m.
  };
  const Tip& operator[](int tip) const { return tips_[tip]; }
  /// C_ac, m/N: how far tip a moves by a unit force on tip c.
  Matrix3d Between(int a, int c) const { return compliance_.block<3, 3>(3 * a, 3 * c); }
  /// b K^-1 b_c^T, m/N: the same of a surface point with row b.
  Matrix3d Coupling(const SparseRow& b, int c) const;
  /// Where a surface point with row b, now at `x_W`, goes when all tips let go.
  Vector3d Released(const SparseRow& b, const Vector3d& x_W) const;

 private:
  static constexpr int kMaxRows = kMaxContacts + kMaxInstruments;
  static constexpr int kMaxTips = kMaxInstruments;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               3 * kMaxRows, 3 * kMaxRows>;
  using Stack = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3 * kMaxRows,
                              3 * kMaxTips>;
  using Small = Eigen::Matrix<double, 3 * kMaxTips, 3 * kMaxTips>;

  struct Row {
    int tip = 0;
    Matrix3d C_loc = Matrix3d::Zero();
    Vector3d x_W = Vector3d::Zero();
    Vector3d force_W = Vector3d::Zero();
  };

  void FillRowCompliance(const LatticeCompliance& lattice);

  int n_;
  int tip_count_ = 0;
  int row_count_ = 0;
  std::array<Row, kMaxRows> rows_;
  std::array<Tip, kMaxTips> tips_;
  ContactWeights weights_;        // (kMaxRows + 1) x n: the rows and a scratch one
  std::vector<int> columns_;      // n: of the row at hand, where it is not zero
  std::vector<double> values_;    // n
  Eigen::MatrixXd response_;      // 3n x 3 rows: K^-1 b_i^T
  Eigen::MatrixXd tip_response_;  // 3n x 3 tips: the same of the condensed tips
  Eigen::VectorXd displacement_;  // 3n: of the tips' forces
  Square row_compliance_;         // C_rows
  Stack share_;                   // C_rows^-1 T C: the rows' forces by a unit force on each tip
  Small compliance_;              // C
};

}  // namespace hpdm
