#pragma once

#include <array>
#include <cstdint>

#include "engine/base/room.h"
#include "engine/base/types.h"
#include "engine/contact/half_space.h"
#include "engine/contact/local_coupling.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/direct_manipulation.h"

namespace hpdm {

/// The contacts of one organ in one step: m contact rows, each a material point x of the surface
/// with its lattice row b. Sized once; a step fills it in place.
///     grasp (bilateral):    x = target
///     press (unilateral):   n . (x - target) <= 0, force on the tissue f_n (friction - n), f_n >=
///     0
///     pair:                 one side of a contact with another organ (OrganContact)
/// A press keeps the point on or below the plane through `target` with the outward normal n. The
/// rows of pairs come last.
class ContactConstraints {
 public:
  enum class RowKind : std::uint8_t { kPress, kGrasp, kPair };
  struct Row {
    RowKind kind = RowKind::kPress;
    int tool = 0;                            ///< -1: none, a pair's row.
    bool shaft = false;                      ///< Contact of the shaft, not of the tip or the jaws.
    int place = 0;                           ///< Of the tip: index in ToolPatches::places.
    Vector3d p_rest_W = Vector3d::Zero();    ///< Rest position of the material point, m.
    Vector3d target_W = Vector3d::Zero();    ///< m.
    Vector3d normal_W = Vector3d::UnitZ();   ///< Outward unit normal; press only.
    Vector3d friction_W = Vector3d::Zero();  ///< Press: tangential force on the tissue over f_n.
    LocalIndentation indentation;  ///< Press: unresolved local indentation by the tip, a ball.
    /// Further local compliance, m/N, symmetric.
    Matrix3d local_compliance_W = Matrix3d::Zero();
    /// Displacement of the point beside the lattice's without any force, m (maxwell_memory.h).
    Vector3d free_W = Vector3d::Zero();
    CoupledRow coupled;  ///< Local compliance to other rows (footprint.h), beside its own.
    Vector3d force_W = Vector3d::Zero();  ///< Result: force on the tissue, N.
    double slip = 0;  ///< Result: lag of the tissue behind `target` for a unit force, m/N.

    double f_n() const { return -normal_W.dot(force_W); }  ///< Press: pressing force, N.
    /// Returns C_loc, m/N, at the row's force: a part of the point's own block of the compliance.
    Matrix3d LocalCompliance() const {
      if (kind != RowKind::kPress || !indentation.indents()) return local_compliance_W;
      return local_compliance_W + indentation.UnderBall(f_n()).Compliance();
    }
  };

  /// `n`: control points of the organ; `functions`, `slots`: numbers of its local functions and
  /// their slots. The columns of the slots follow those of the control points.
  explicit ContactConstraints(int n, int functions = 0, int slots = 0)
      : refinement(functions, slots), weights_(ContactWeights::Zero(kMaxContacts, n + slots)) {}

  /// A copy takes over the rows in use.
  ContactConstraints(const ContactConstraints& other)
      : refinement(other.refinement), rows_(Rows::kUntouched), weights_(0, 0) {
    TakeRows(other);
  }
  ContactConstraints& operator=(const ContactConstraints& other) {
    refinement = other.refinement;
    TakeRows(other);
    return *this;
  }

  /// The local functions in use; chosen before rows are added.
  ActiveRefinement refinement;

  void Clear() { size_ = 0; }
  int size() const { return size_; }
  /// Returns the number of rows before the first of a pair: those of the tools.
  int tool_rows() const {
    int count = 0;
    while (count < size_ && rows_[count].kind != RowKind::kPair) ++count;
    return count;
  }

  /// Adds a tool's row with zero weights, to be filled in; returns nullptr if there are
  /// kMaxToolRows.
  Row* Add() { return size_ < kMaxToolRows ? AddRow() : nullptr; }
  /// Adds a pair's row with zero weights, to be filled in; returns nullptr if there are
  /// kMaxContacts rows.
  Row* AddPair() {
    Row* const row = size_ < kMaxContacts ? AddRow() : nullptr;
    if (row == nullptr) return nullptr;
    row->kind = RowKind::kPair;
    row->tool = -1;
    return row;
  }
  void DropLast() { --size_; }
  Row& operator[](int i) { return rows_[i]; }
  const Row& operator[](int i) const { return rows_[i]; }

  /// Returns the weights of the rows in use, m x (n + slots).
  auto Weights() const { return weights_.topRows(size_); }
  auto WeightRow(int i) { return weights_.row(i); }

 private:
  using Rows = Room<Row, kMaxContacts>;

  void TakeRows(const ContactConstraints& other) {
    size_ = other.size_;
    rows_.Take(other.rows_, size_);
    weights_.resize(other.weights_.rows(), other.weights_.cols());
    weights_.topRows(size_) = other.weights_.topRows(size_);
  }
  Row* AddRow() {
    weights_.row(size_).setZero();
    rows_[size_] = Row();
    return &rows_[size_++];
  }

  int size_ = 0;
  Rows rows_;
  ContactWeights weights_;
};

/// A contact between two organs: a row in each one's constraints. The first organ is pressed like
/// tissue under a tip, the second moves against it:
///     g = gap + n . (u_second - u_first) >= 0,   f_n >= 0,   f_n g = 0
/// with the rows' displacements u. The force is f_n (t - n) on the first and minus that on the
/// second. It sticks, with the tangential part of u_second - u_first at `tie`, while |t| stays below
/// `friction`; otherwise it slides with |t| = friction against the slip (Coulomb).
struct OrganContact {
  std::uint64_t key = 0;      ///< The same from step to step.
  std::array<int, 2> body{};  ///< Indices of the two organs among the bodies of the problem.
  std::array<int, 2> row{};   ///< Their rows.
  Vector3d normal_W = Vector3d::UnitZ();  ///< Unit, from the first organ to the second.
  double gap = 0;                         ///< m, with both organs at rest.
  double friction = 0;                    ///< Coulomb coefficient.
  Vector3d tie_W = Vector3d::Zero();      ///< m; only its tangential part counts.
  double f_n = 0;                         ///< Pressing force, N: a guess at first, then the result.
  Vector3d f_t_W = Vector3d::Zero();      ///< N, f_n t on the first: the same.
  double indentation = 0;                 ///< Result: how far f_n alone moves the two apart, m.
};

}  // namespace hpdm
