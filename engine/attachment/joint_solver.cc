#include "engine/attachment/joint_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using Eigen::Index;

// Diagonal entries that count as zero, over the largest.
constexpr double kNothing = 1e-14;
// w over w_0, below which w has lost more digits than it may.
constexpr double kLeastShare = 1e-6;

// Finds C with A = C C^T for a positive semi-definite A, whose lower triangle is read. The largest diagonal
// entry of what is left comes next, so what is left out in the end is as small as these entries: a free
// organ can be 1e7 times softer than its layer. Returns the number of C's columns. `rest`: scratch.
Index FindRoot(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Ref<Eigen::MatrixXd> C,
               Eigen::Ref<Eigen::VectorXd> rest) {
  const Index size = A.rows();
  for (Index j = 0; j < size; ++j) A.row(j).tail(size - j) = A.col(j).tail(size - j).transpose();
  rest = A.diagonal();
  const double nothing = size > 0 ? kNothing * rest.maxCoeff() : 0;
  for (Index rank = 0; rank < size; ++rank) {
    Index pivot = 0;
    if (!(rest.maxCoeff(&pivot) > nothing)) return rank;
    auto column = C.col(rank);
    column = A.col(pivot);
    column.noalias() -= C.leftCols(rank) * C.row(pivot).head(rank).transpose();
    column /= std::sqrt(rest[pivot]);
    rest -= column.cwiseAbs2();
    rest[pivot] = 0;
  }
  return size;
}

// Y = A X, or Y += A X, for each axis of interleaved rows if axes is 3. The rows of X and Y begin there.
void MultiplyAxes(const Eigen::Ref<const RowMajorMatrix>& A, int axes, const double* X,
                  Index x_stride, double* Y, Index y_stride, bool add = false) {
  using Stride = Eigen::OuterStride<>;
  for (int axis = 0; axis < axes; ++axis) {
    const Eigen::Map<const FewColumns, 0, Stride> from(X + axis * x_stride, A.cols(), kFewColumns,
                                                       Stride(axes * x_stride));
    Eigen::Map<FewColumns, 0, Stride> to(Y + axis * y_stride, A.rows(), kFewColumns,
                                         Stride(axes * y_stride));
    if (add) {
      MultiplyAndAdd(A, from, to);
    } else {
      Multiply(A, from, to);
    }
  }
}

// Returns the most columns that C can have: three of each mode and one of each sample.
Index MostRank(const AttachmentJoint& joint) {
  Index most = 0;
  for (const AttachmentJoint::Layer& layer : joint.layers()) {
    most += 3 * layer.samples.rows() + layer.samples.cols();
  }
  return most;
}

}  // namespace

JointSolver::JointSolver(std::shared_ptr<const AttachmentJoint> joint)
    : joint_(std::move(joint)),
      unknowns_(3 * joint_->modes()),
      duct_unknowns_(joint_->ducts().empty() ? 0 : unknowns_ - 3 * joint_->ducts()[0].first_mode),
      most_rank_(MostRank(*joint_)),
      factor_(FullGroups(most_rank_ + kFewColumns), most_rank_),
      duct_rows_(most_rank_, duct_unknowns_),
      duct_compliance_(duct_unknowns_, duct_unknowns_),
      duct_root_(duct_compliance_),
      duct_stiffness_(duct_compliance_),
      duct_factor_(duct_unknowns_),
      duct_forces_(Eigen::MatrixXd::Zero(duct_unknowns_, duct_unknowns_)),
      product_(RowMajorMatrix::Zero(most_rank_, FullGroups(unknowns_) + kFewColumns)),
      transposed_(unknowns_, FullGroups(most_rank_ + kFewColumns)),
      y_(std::max(most_rank_, unknowns_), kFewColumns),
      w_(unknowns_, kFewColumns),
      one_(w_),
      q_(w_),
      step_(y_),
      moved_(Eigen::VectorXd::Zero(duct_unknowns_)),
      duct_work_(duct_unknowns_, duct_unknowns_),
      duct_inner_(duct_unknowns_, duct_unknowns_),
      root_(unknowns_, unknowns_),
      rest_(unknowns_, 1) {
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    const Index s = layer.samples.rows();
    stiffness_.push_back(Eigen::MatrixXd::Zero(s, s));
    roots_.emplace_back(3 * layer.first_mode, s, s, 3);
  }
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    roots_.emplace_back(3 * layer.first_mode, 3 * layer.samples.rows(), layer.samples.cols(), 1);
  }
}

Index JointSolver::MostHalfSize(const AttachmentJoint& joint) {
  return MostRank(joint) + 3 * joint.modes();
}

Eigen::Ref<Eigen::MatrixXd> JointSolver::RoomFor(std::size_t layer) {
  return stiffness_[layer].setZero();
}

void JointSolver::TakeAlike(std::size_t layer) {
  Eigen::MatrixXd& A = stiffness_[layer];
  Root& root = Alike(layer);
  auto C = root_.topLeftCorner(A.rows(), A.rows());
  root.changed = true;
  root.rank = FindRoot(A, C, rest_.head(A.rows()));
  root.columns.leftCols(root.rank) = C.leftCols(root.rank);
  root.transposed.topRows(root.rank) = C.leftCols(root.rank).transpose();
}

void JointSolver::ClearBeside(std::size_t layer) {
  Root& root = Beside(layer);
  root.changed = root.changed || root.rank > 0;
  root.rank = 0;
}

void JointSolver::AddBeside(std::size_t layer, const Eigen::Ref<const Eigen::VectorXd>& m,
                            const Vector3d& v) {
  Root& root = Beside(layer);
  root.changed = true;
  auto row = root.transposed.row(root.rank);
  for (Index j = 0; j < m.size(); ++j) row.segment<3>(3 * j) = m[j] * v.transpose();
  root.columns.col(root.rank++) = row.transpose();
}

Eigen::MatrixXd JointSolver::StiffnessOf(std::size_t layer) const {
  const Root& root = roots_[layer];
  const Eigen::MatrixXd C = root.columns.leftCols(root.rank);
  const Eigen::MatrixXd stiffness = C * C.transpose();
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(3 * C.rows(), 3 * C.rows());
  for (Index j = 0; j < C.rows(); ++j) {
    for (Index i = 0; i < C.rows(); ++i) {
      spread.block<3, 3>(3 * i, 3 * j) = stiffness(i, j) * Matrix3d::Identity();
    }
  }
  return spread;
}

// Y = C^T X, for the roots that begin in the first `rows` of Y. `changed_only`: of these the changed.
void JointSolver::MultiplyRoots(const Eigen::Ref<const FewColumns>& X, Eigen::Ref<FewColumns> Y,
                                Index rows, bool changed_only) const {
  for (const Root& root : roots_) {
    if (root.first >= rows) break;
    if (changed_only && !root.changed) continue;
    MultiplyAxes(root.transposed.topRows(root.rank), root.axes,
                 X.data() + root.first_row * X.outerStride(), X.outerStride(),
                 Y.data() + root.first * Y.outerStride(), Y.outerStride());
  }
}

void JointSolver::FactorLayers() {
  const Index before = rank_;
  rank_ = 0;
  Index kept = before;  // rows of L that stay
  for (Root& root : roots_) {
    root.changed = root.changed || root.first != rank_;
    root.first = rank_;
    if (root.changed) kept = std::min(kept, rank_);
    rank_ += root.columns_of_C();
  }
  const RowMajorMatrix& G = joint_->compliance();
  for (Index column = 0; column < unknowns_; column += kFewColumns) {
    MultiplyRoots(G.middleCols<kFewColumns>(column), product_.middleCols<kFewColumns>(column),
                  rank_, true);
  }
  for (Root& root : roots_) root.changed = false;
  const Index layers = unknowns_ - duct_unknowns_, found = rank_ - kept;
  transposed_.block(0, kept, layers, found) = product_.block(kept, 0, found, layers).transpose();
  transposed_.block(0, rank_, layers, kFewColumns).setZero();
  // The rows of the symmetric B are written as columns of its lower triangle. What L has above them
  // takes their first columns to L's.
  const auto above = factor_.topLeftCorner(kept, kept);
  for (Index column = kept; column < rank_; column += kFewColumns) {
    using Rows = Eigen::Map<FewColumns, 0, Eigen::OuterStride<>>;
    const Eigen::OuterStride<> stride(factor_.rows());
    Rows rows(factor_.data() + column, rank_, kFewColumns, stride);
    MultiplyRoots(transposed_.block(0, column, layers, kFewColumns), rows, column + kFewColumns);
    SolveLower(above, Rows(factor_.data() + column, kept, kFewColumns, stride));
  }
  auto B = factor_.topLeftCorner(rank_, rank_);
  B.diagonal().tail(found).array() += 1;
  FactorLower(B, kept);
  if (duct_unknowns_ > 0) CondenseLayers();
}

// Finds W and S.
void JointSolver::CondenseLayers() {
  const RowMajorMatrix& G = joint_->compliance();
  const Index layers = unknowns_ - duct_unknowns_;
  const auto B = factor_.topLeftCorner(rank_, rank_);
  auto y = y_.topRows(rank_);
  for (Index column = 0; column < duct_unknowns_; column += kFewColumns) {
    const Index count = std::min<Index>(kFewColumns, duct_unknowns_ - column);
    y = product_.block(0, layers + column, rank_, kFewColumns);
    SolveLower(B, y);
    duct_rows_.block(0, column, rank_, count) = y.leftCols(count);
  }
  const auto W = duct_rows_.topRows(rank_);
  for (Index j = 0; j < duct_unknowns_; ++j) {
    for (Index i = 0; i < duct_unknowns_; ++i) {
      duct_compliance_(i, j) = G(layers + i, layers + j) - W.col(i).dot(W.col(j));
    }
  }
  const Index rank = FindRoot(duct_compliance_, duct_root_, rest_.head(duct_unknowns_));
  duct_root_.rightCols(duct_unknowns_ - rank).setZero();
}

void JointSolver::TakeDucts(std::span<DuctState> ducts) {
  if (duct_unknowns_ == 0) return;
  for (int attempt = 0; attempt < 2; ++attempt) {
    duct_stiffness_.setZero();
    Index first = 0;
    for (const DuctState& duct : ducts) {
      duct_stiffness_.block(first, first, duct.unknowns(), duct.unknowns()) = duct.stiffness();
      first += duct.unknowns();
    }
    // The organs hold the ducts if 1 + s^T R s is positive definite, with S = s s^T.
    duct_work_.noalias() = duct_stiffness_.lazyProduct(duct_root_);
    duct_inner_.noalias() = duct_root_.transpose().lazyProduct(duct_work_);
    duct_inner_.diagonal().array() += 1;
    if (FactorLower(duct_inner_)) break;
    for (DuctState& duct : ducts) duct.Stabilise();
  }
  duct_work_.noalias() = duct_compliance_.lazyProduct(duct_stiffness_);
  duct_work_.diagonal().array() += 1;
  duct_factor_.compute(duct_work_);
  duct_work_.noalias() =
      duct_factor_.solve(Eigen::MatrixXd::Identity(duct_unknowns_, duct_unknowns_));
  duct_inner_.noalias() = duct_stiffness_.lazyProduct(duct_work_);
  duct_forces_ = (duct_inner_ + duct_inner_.transpose()) / 2;
}

void JointSolver::Halve(const Eigen::Ref<const Eigen::MatrixXd>& w_0,
                        Eigen::Ref<Eigen::MatrixXd> half) const {
  const auto B = factor_.topLeftCorner(rank_, rank_);
  const auto W = duct_rows_.topRows(rank_);
  auto y = y_.topRows(rank_);
  for (Index first = 0; first < w_0.cols(); first += kFewColumns) {
    const Index count = std::min<Index>(kFewColumns, w_0.cols() - first);
    w_.setZero();
    w_.leftCols(count) = w_0.middleCols(first, count);
    MultiplyRoots(w_, y, rank_);
    SolveLower(B, y);
    auto columns = half.middleCols(first, count);
    columns.topRows(rank_) = y.leftCols(count);
    auto of_ducts = columns.bottomRows(duct_unknowns_);
    of_ducts = w_.leftCols(count).bottomRows(duct_unknowns_);
    of_ducts -= W.transpose().lazyProduct(y.leftCols(count));
  }
}

void JointSolver::TakeDuctForces(Eigen::Ref<Eigen::MatrixXd> half) const {
  if (duct_unknowns_ == 0) return;
  auto of_ducts = half.bottomRows(duct_unknowns_);
  for (Index c = 0; c < half.cols(); ++c) {
    auto w = y_.col(0).head(duct_unknowns_);
    w.noalias() = duct_forces_.lazyProduct(of_ducts.col(c));
    of_ducts.col(c) = w;
  }
}

void JointSolver::FindForces(const Eigen::Ref<const FewColumns>& w_0,
                             Eigen::Ref<FewColumns> q) const {
  BeginSolution(w_0);
  q.bottomRows(duct_unknowns_).noalias() = duct_forces_.lazyProduct(w_.topRows(duct_unknowns_));
  EndSolution(q);
}

// Finds y, and w_d in the first rows of w_.
void JointSolver::BeginSolution(const Eigen::Ref<const FewColumns>& w_0) const {
  auto y = y_.topRows(rank_);
  MultiplyRoots(w_0, y, rank_);
  SolveLower(factor_.topLeftCorner(rank_, rank_), y);
  auto w = w_.topRows(duct_unknowns_);
  w = w_0.bottomRows(duct_unknowns_);
  w -= duct_rows_.topRows(rank_).transpose().lazyProduct(y);
}

// Fills the layers' rows of q, with those of the ducts there, and leaves z = L^-T (y - W^T q_d) in y_.
void JointSolver::EndSolution(Eigen::Ref<FewColumns> q) const {
  auto y = y_.topRows(rank_);
  y -= duct_rows_.topRows(rank_).lazyProduct(q.bottomRows(duct_unknowns_));
  SolveLowerTransposed(factor_.topLeftCorner(rank_, rank_), y);
  SetRootForces(y, q);
}

// q = C z in the layers' rows.
void JointSolver::SetRootForces(const Eigen::Ref<const FewColumns>& z,
                                Eigen::Ref<FewColumns> q) const {
  q.topRows(unknowns_ - duct_unknowns_).setZero();
  for (const Root& root : roots_) {
    MultiplyAxes(root.columns.leftCols(root.rank), root.axes,
                 z.data() + root.first * z.outerStride(), z.outerStride(),
                 q.data() + root.first_row * q.outerStride(), q.outerStride(), true);
  }
}

void JointSolver::FindForces(const Eigen::VectorXd& w_0, Eigen::VectorXd* q) const {
  one_.setZero();
  one_.col(0) = w_0;
  BeginSolution(one_);
  q_.setZero();
  if (duct_unknowns_ > 0) {
    moved_ = duct_factor_.solve(w_.col(0).head(duct_unknowns_));
    q_.col(0).tail(duct_unknowns_) = duct_stiffness_.lazyProduct(moved_);
  }
  EndSolution(q_);
  *q = q_.col(0);
}

void JointSolver::FindForces(const Eigen::VectorXd& w_0, Eigen::VectorXd* q,
                             Eigen::VectorXd* w) const {
  FindForces(w_0, q);
  *w = w_0;
  w->noalias() -= joint_->compliance().leftCols(unknowns_) * *q;
  if (w->norm() < kLeastShare * w_0.norm()) Refine(q, w);
  w->tail(duct_unknowns_) = moved_;
}

// Follows FindForces(w_0, q), which leaves z in y_. The solution has C^T w = z with q = C z.
void JointSolver::Refine(Eigen::VectorXd* q, Eigen::VectorXd* w) const {
  const auto B = factor_.topLeftCorner(rank_, rank_);
  auto error = step_.topRows(rank_);
  one_.col(0) = *w;
  MultiplyRoots(one_, error, rank_);
  error -= y_.topRows(rank_);
  SolveLower(B, error);
  SolveLowerTransposed(B, error);
  q_.setZero();
  SetRootForces(error, q_);
  *q += q_.col(0);
  w->noalias() -= joint_->compliance().leftCols(unknowns_) * q_.col(0);
}

}  // namespace hpdm
