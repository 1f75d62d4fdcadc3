#pragma once

#include <array>

#include "engine/base/check.h"
#include "engine/base/copying.h"
#include "engine/base/work_array.h"
#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/snapshots.h"

namespace hpdm {

/// The memory of viscoelastic tissue at a contact row's point (maxwell_memory.h), m.
struct RowMemory {
  Vector3d excess_W = Vector3d::Zero();          ///< MaxwellMemory::Excess, with the local part.
  BranchStrains branches_W = NoBranchStrains();  ///< Of the point.
};

/// Condenses the tips that touch one organ, or are about to, to one point each (engine/README.md,
/// section 4). A place where a shaft presses counts as a tip. A press has one row b, a grasp one row for each grasped point, which the jaws move
/// together. Over the rows of all tips,
///     C_rows = B K^-1 B^T + C_loc
///     S = T^T C_rows^-1 T,   C = S^-1          T: identities stacked per tip
///     f = T^T (row forces),   p_original = x + excess - C f
///
/// 1. p_original is the position of each tip's point x after all tips let go and the tissue's memory
///    has faded. `excess` is zero for elastic tissue (MaxwellMemory::Excess).
/// 2. The point x of a press is its row's point. The point x of a grasp is the mean of its points
///    with the weights C_rows^-1 T C. About this point f has the least torque.
/// 3. With presses only, C = C_rows.
/// 4. Rotating the jaws by theta about x moves the rows by theta x r_i, r_i = x_i - x. It needs the
///    force C^-1 turn theta with turn = sum_i (C_rows^-1 T C)_i^T [-r_i x].
///
/// Sized once for the organ; a step fills it in place. Deformation thread; allocates nothing.
class TipCompliance {
 public:
  static constexpr int kMaxTips = kMaxInstruments * kToolPlaces;
  static constexpr int kMaxRows = kMaxToolRows + kMaxTips;

  /// `n`: control points of the organ and slots for its local functions.
  explicit TipCompliance(int n);

  void Clear();
  /// Begins the next tip, which must get at least one row. Returns its index. `owner`: the place
  /// that it belongs to, tool * kToolPlaces + index in ToolPatches::places.
  int AddTip(int owner = 0);
  /// Adds a row to the last tip and returns its weights, all zero, to be filled in. `C_loc`: local
  /// compliance, m/N; `x_W`: present position of the point, m; `force_W`: force on the tissue
  /// there, N; `coupled`: local compliance to other rows; `memory`: of viscoelastic tissue. At most
  /// kMaxToolRows rows, and one more for each tip.
  auto AddRow(const Matrix3d& C_loc, const Vector3d& x_W, const Vector3d& force_W,
              const CoupledRow& coupled = {}, const RowMemory& memory = {}) {
    HPDM_CHECK(row_count_ < kMaxRows && tip_count_ > 0);
    rows_[row_count_] = {tip_count_ - 1, C_loc, x_W, force_W, coupled, memory};
    weights_.row(row_count_).setZero();
    return weights_.row(row_count_++);
  }
  int size() const { return tip_count_; }

  /// Returns a zero row for another point, valid until the next call.
  auto ScratchRow() {
    weights_.row(kMaxRows).setZero();
    return weights_.row(kMaxRows);
  }
  /// Returns the non-zero entries of a row, valid until the next call.
  SparseRow Compress(const Eigen::Ref<const Eigen::RowVectorXd>& row) {
    return CompressInto(0, row);
  }
  /// Returns the non-zero entries of a row given by those of its control points and the values of the
  /// finer functions, of which those in use count; valid until the next call.
  SparseRow Join(const SparseRow& lattice, const SparseRow& finer, const ActiveRefinement& active);

  /// Computes the results below.
  void Condense(const LatticeCompliance& lattice);

  struct Tip {
    int owner = 0;                             ///< See AddTip.
    Vector3d x_W = Vector3d::Zero();           ///< m.
    Vector3d force_W = Vector3d::Zero();       ///< N, on the tissue.
    Vector3d p_original_W = Vector3d::Zero();  ///< m.
    /// Displacement of x that needs the same force as a rotation of all rows about x, m/rad.
    Matrix3d turn_W = Matrix3d::Zero();
    BranchStrains branches_W = NoBranchStrains();  ///< m, of x.
  };
  const Tip& operator[](int tip) const { return tips_[tip]; }
  /// Returns the index of another tool's tip, no shaft, that presses most; -1 if no other tool is
  /// on the organ.
  int OtherTip(int tip) const;
  /// Returns the index of the same tool's other tip that presses most; -1: there is none.
  int TipBeside(int tip) const;
  /// Returns C_ac (m/N): the displacement of tip a for a unit force on tip c.
  Matrix3d Between(int a, int c) const { return compliance_.block<3, 3>(3 * a, 3 * c); }
  /// Returns b K^-1 b_c^T (m/N): the same for a surface point with row b.
  Matrix3d Coupling(const SparseRow& b, int c) const;
  /// K^-1 b^T of the condensed tip, 3n x 3: the displacements for a unit force along each axis.
  auto Response(int tip) const { return tip_response_.middleCols<3>(3 * tip); }
  /// Returns the position of a surface point with row b, now at `x_W` (m), after all tips let go.
  Vector3d Released(const SparseRow& b, const Vector3d& x_W) const;

 private:
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                               3 * kMaxRows, 3 * kMaxRows>;
  using Stack = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3 * kMaxRows,
                              3 * kMaxTips>;
  using Small = Eigen::Matrix<double, 3 * kMaxTips, 3 * kMaxTips>;
  using SmallSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                    3 * kMaxTips, 3 * kMaxTips>;

  struct Row {
    int tip = 0;
    Matrix3d C_loc = Matrix3d::Zero();
    Vector3d x_W = Vector3d::Zero();
    Vector3d force_W = Vector3d::Zero();
    CoupledRow coupled;
    RowMemory memory;
  };

  SparseRow CompressInto(std::size_t first, const Eigen::Ref<const Eigen::RowVectorXd>& row);
  void FillRowCompliance(const LatticeCompliance& lattice);
  auto RowCompliance() { return row_compliance_.topLeftCorner(3 * row_count_, 3 * row_count_); }
  int MostPressing(int tip, bool same_tool) const;

  int n_;
  int tip_count_ = 0;
  int row_count_ = 0;
  std::array<Row, kMaxRows> rows_;
  std::array<Tip, kMaxTips> tips_;
  std::array<int, kMaxTips> owners_{};
  WorkMatrixOf<ContactWeights> weights_;  // (kMaxRows + 1) x n: the rows and a scratch row
  // kMaxRows n: the non-zero entries of the compressed row, or of all rows
  WorkArray<int> columns_;
  WorkArray<double> values_;
  WorkMatrix response_;  // 3n x 3 rows: K^-1 b_i^T, in part (RespondInPart)
  // 3n x (3 tips + 1): the same for the condensed tips, and the displacement by the tips' forces
  WorkMatrix tip_response_;
  WorkMatrix row_compliance_;  // 3 kMaxRows, square: C_rows in its corner
  Stack share_;                // C_rows^-1 T C: the rows' forces for a unit force on each tip
  Small compliance_;           // C
  WorkMatrix forces_;  // 3 kMaxRows x (3 kMaxTips + 1): share_, and the rows' present forces, N
};

}  // namespace hpdm
