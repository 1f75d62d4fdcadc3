#include "engine/contact/tip_compliance.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace hpdm {
namespace {

// Returns b times a 3n x 3 response or a 3n vector.
template <class Columns>
auto Product(const SparseRow& b, const Columns& response) {
  Eigen::Matrix<double, 3, Columns::ColsAtCompileTime> sum;
  sum.setZero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    sum += b.weights[i] * response.template middleRows<3>(3 * b.control_points[i]);
  }
  return sum;
}

// Returns the inverse of a matrix of up to two tips with the size known at compile time: it is faster
// so. Of more, in any size.
template <class Square>
Square Inverse(const Square& stiffness) {
  using TwoTips = Eigen::Matrix<double, 6, 6>;
  if (stiffness.rows() > TwoTips::RowsAtCompileTime) return stiffness.inverse();
  TwoTips padded = TwoTips::Identity();  // 1 for absent tips
  padded.topLeftCorner(stiffness.rows(), stiffness.cols()) = stiffness;
  const TwoTips inverse = padded.inverse();
  return inverse.topLeftCorner(stiffness.rows(), stiffness.cols());
}

}  // namespace

TipCompliance::TipCompliance(int n)
    : n_(n),
      weights_(kMaxRows + 1, n),
      columns_(kMaxRows * static_cast<std::size_t>(n)),
      values_(kMaxRows * static_cast<std::size_t>(n)),
      response_(3 * n, 3 * kMaxRows),
      tip_response_(3 * n, 3 * kMaxTips + 1),
      row_compliance_(3 * kMaxRows, 3 * kMaxRows),
      compliance_(Small::Zero()),
      forces_(3 * kMaxRows, 3 * kMaxTips + 1) {}

void TipCompliance::Clear() {
  tip_count_ = 0;
  row_count_ = 0;
}

int TipCompliance::AddTip(int owner) {
  HPDM_CHECK(tip_count_ < kMaxTips);
  owners_[tip_count_] = owner;
  return tip_count_++;
}

int TipCompliance::OtherTip(int tip) const { return MostPressing(tip, false); }

int TipCompliance::TipBeside(int tip) const { return MostPressing(tip, true); }

// Returns the tip of the same or of another tool, besides `tip`, with the largest force.
int TipCompliance::MostPressing(int tip, bool same_tool) const {
  int found = -1;
  double most = -1;
  for (int t = 0; t < tip_count_; ++t) {
    const bool is_tip = owners_[t] % kToolPlaces < kMaxPlaces;
    const bool is_same = owners_[t] / kToolPlaces == owners_[tip] / kToolPlaces;
    const double force = tips_[t].force_W.squaredNorm();
    if (t == tip || !is_tip || is_same != same_tool || force <= most) continue;
    found = t;
    most = force;
  }
  return found;
}

// Writes the entries from number `first` on.
SparseRow TipCompliance::CompressInto(std::size_t first,
                                      const Eigen::Ref<const Eigen::RowVectorXd>& row) {
  std::size_t entries = first;
  for (int a = 0; a < n_; ++a) {
    if (row[a] == 0) continue;
    columns_[entries] = a;
    values_[entries++] = row[a];
  }
  return {{columns_.data() + first, entries - first}, {values_.data() + first, entries - first}};
}

SparseRow TipCompliance::Join(const SparseRow& lattice, const SparseRow& finer,
                              const ActiveRefinement& active) {
  std::size_t entries = 0;
  for (std::size_t i = 0; i < lattice.weights.size(); ++i) {
    if (lattice.weights[i] == 0) continue;
    columns_[entries] = lattice.control_points[i];
    values_[entries++] = lattice.weights[i];
  }
  const std::size_t first = entries;
  for (std::size_t i = 0; i < finer.weights.size(); ++i) {
    const int slot = active.Slot(finer.control_points[i]);
    if (slot < 0 || finer.weights[i] == 0) continue;
    const int column = n_ - active.slots() + slot;
    std::size_t at = entries++;  // the columns ascend
    for (; at > first && columns_[at - 1] > column; --at) {
      columns_[at] = columns_[at - 1];
      values_[at] = values_[at - 1];
    }
    columns_[at] = column;
    values_[at] = finer.weights[i];
  }
  return {{columns_.data(), entries}, {values_.data(), entries}};
}

void TipCompliance::FillRowCompliance(const LatticeCompliance& lattice) {
  std::array<SparseRow, kMaxRows> rows;
  std::size_t entries = 0;
  for (int i = 0; i < row_count_; ++i) {
    rows[ToSize(i)] = CompressInto(entries, weights_.row(i));
    entries += rows[ToSize(i)].weights.size();
  }
  lattice.RespondInPart({rows.data(), ToSize(row_count_)}, response_.leftCols(3 * row_count_));
  for (int i = 0; i < row_count_; ++i) {
    for (int j = 0; j <= i; ++j) {
      Matrix3d C = Product(rows[ToSize(i)], response_.middleCols<3>(3 * j));
      if (j < i) C += rows_[i].coupled.To(rows_[j].coupled);
      row_compliance_.block<3, 3>(3 * i, 3 * j) = C;
      row_compliance_.block<3, 3>(3 * j, 3 * i) = C.transpose();
    }
  }
  lattice.AddOtherPart(RowCompliance());
  for (int i = 0; i < row_count_; ++i) {
    auto own = row_compliance_.block<3, 3>(3 * i, 3 * i);
    own = ((own + own.transpose()) / 2 + rows_[i].C_loc).eval();
  }
}

void TipCompliance::Condense(const LatticeCompliance& lattice) {
  if (row_count_ == 0) return;
  FillRowCompliance(lattice);
  const int tips = 3 * tip_count_;
  compliance_.setZero();
  if (row_count_ == tip_count_) {
    share_.setIdentity(3 * row_count_, tips);
    compliance_.topLeftCorner(tips, tips) = RowCompliance();
  } else {
    // Grasped points that (nearly) coincide share their force, as in ContactSolver.
    auto rows = RowCompliance();
    rows.diagonal().array() += 1e-9 * rows.diagonal().maxCoeff();
    share_.setZero(3 * row_count_, tips);
    for (int i = 0; i < row_count_; ++i) {
      share_.block<3, 3>(3 * i, 3 * rows_[i].tip).setIdentity();
    }
    const Eigen::LDLT<Eigen::Ref<Square>> factor(rows);
    factor.solveInPlace(share_);
    SmallSquare stiffness = SmallSquare::Zero(tips, tips);  // S
    for (int i = 0; i < row_count_; ++i) {
      stiffness.middleRows<3>(3 * rows_[i].tip).leftCols(tips) += share_.middleRows<3>(3 * i);
    }
    const SmallSquare compliance = Inverse(stiffness);
    compliance_.topLeftCorner(tips, tips) = (compliance + compliance.transpose()) / 2;
    share_ = (share_ * compliance_.topLeftCorner(tips, tips)).eval();
  }

  auto forces = forces_.topLeftCorner(3 * row_count_, tips + 1);
  forces.leftCols(tips) = share_;
  for (int t = 0; t < tip_count_; ++t) tips_[t] = {.owner = owners_[t]};
  for (int i = 0; i < row_count_; ++i) {
    const Row& row = rows_[i];
    forces.col(tips).segment<3>(3 * i) = row.force_W;
    tips_[row.tip].force_W += row.force_W;
    tips_[row.tip].x_W += share_.block<3, 3>(3 * i, 3 * row.tip).transpose() * row.x_W;
  }
  for (int c = 0; c <= tips; ++c) {  // a general product would allocate
    auto moved = tip_response_.col(c);
    moved.setZero();
    for (int k = 0; k < 3 * row_count_; ++k) {
      if (forces(k, c) != 0) moved += forces(k, c) * response_.col(k);
    }
  }
  lattice.AddOtherPart(forces, tip_response_.leftCols(tips + 1));
  for (int i = 0; i < row_count_; ++i) {
    Tip& tip = tips_[rows_[i].tip];
    const Vector3d r_W = rows_[i].x_W - tip.x_W;
    Matrix3d cross;
    cross << 0, -r_W.z(), r_W.y(), r_W.z(), 0, -r_W.x(), -r_W.y(), r_W.x(), 0;
    tip.turn_W -= share_.block<3, 3>(3 * i, 3 * rows_[i].tip).transpose() * cross;
  }
  for (int a = 0; a < tip_count_; ++a) {
    tips_[a].p_original_W = tips_[a].x_W;
  }
  for (int i = 0; i < row_count_; ++i) {
    const Row& row = rows_[i];
    if (row.memory.excess_W.isZero(0)) continue;
    const Matrix3d share = share_.block<3, 3>(3 * i, 3 * row.tip).transpose();
    Tip& tip = tips_[row.tip];
    tip.p_original_W += share * row.memory.excess_W;
    for (std::size_t k = 0; k < tip.branches_W.size(); ++k) {
      tip.branches_W[k] += share * row.memory.branches_W[k];
    }
  }
  for (int a = 0; a < tip_count_; ++a) {
    for (int c = 0; c < tip_count_; ++c) tips_[a].p_original_W -= Between(a, c) * tips_[c].force_W;
  }
}

Matrix3d TipCompliance::Coupling(const SparseRow& b, int c) const {
  return Product(b, tip_response_.middleCols<3>(3 * c));
}

Vector3d TipCompliance::Released(const SparseRow& b, const Vector3d& x_W) const {
  return tip_count_ == 0 ? x_W : Vector3d(x_W - Product(b, tip_response_.col(3 * tip_count_)));
}

}  // namespace hpdm
