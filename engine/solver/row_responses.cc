#include "engine/solver/row_responses.h"

#include <algorithm>

namespace hpdm {

RowResponses::RowResponses(const Eigen::MatrixXd& inverse)
    : inverse_(&inverse),
      n_(static_cast<int>(inverse.rows() / 3)),
      place_(static_cast<std::size_t>(n_)),
      touched_(static_cast<std::size_t>(n_)),
      runs_(static_cast<std::size_t>(n_)),
      entries_(kMaxContacts * static_cast<std::size_t>(n_)),
      column_(3 * n_, 3),
      moved_(3 * n_, 3 * kMaxContacts),
      row_compliance_(3 * kMaxContacts, 3 * kMaxContacts),
      forces_(3, n_) {}

void RowResponses::Gather(const ContactConstraints& contacts) {
  constexpr int kUntouched = -1;
  std::fill(place_.begin(), place_.end(), kUntouched);
  row_count_ = contacts.size();
  for (int i = 0; i < row_count_; ++i) {
    const auto row = static_cast<std::size_t>(i);
    entry_count_[row] = 0;
    for (int a = 0; a < n_; ++a) {
      const double weight = contacts.Weights()(i, a);
      if (weight == 0) continue;
      entries_[row * static_cast<std::size_t>(n_) + entry_count_[row]++] = {a, 0, weight};
      place_[static_cast<std::size_t>(a)] = 0;
    }
  }
  count_ = 0;
  run_count_ = 0;
  for (int a = 0; a < n_; ++a) {
    int& place = place_[static_cast<std::size_t>(a)];
    if (place == kUntouched) continue;
    const bool follows = a > 0 && place_[static_cast<std::size_t>(a - 1)] != kUntouched;
    if (!follows) runs_[run_count_++] = {a, count_, 0};
    ++runs_[run_count_ - 1].length;
    touched_[static_cast<std::size_t>(count_)] = a;
    place = count_++;
  }
  for (int i = 0; i < row_count_; ++i) {
    const auto row = static_cast<std::size_t>(i);
    Entry* const first = entries_.data() + row * static_cast<std::size_t>(n_);
    for (std::size_t e = 0; e < entry_count_[row]; ++e) {
      first[e].place = place_[static_cast<std::size_t>(first[e].point)];
    }
  }
}

// Computes K^-1 B^T at the touched control points. Reads each of their columns once, for all rows.
void RowResponses::MoveRows() {
  const int size = 3 * count_;
  moved_.topLeftCorner(size, 3 * row_count_).setZero();
  std::array<std::size_t, kMaxContacts> next{};  // entry of each row; entries follow the points
  for (int t = 0; t < count_; ++t) {
    const int a = touched_[static_cast<std::size_t>(t)];
    for (std::size_t r = 0; r < run_count_; ++r) {
      const Run& run = runs_[r];
      column_.middleRows(3 * run.place, 3 * run.length) =
          inverse_->middleCols<3>(3 * a).middleRows(3 * run.first, 3 * run.length);
    }
    for (int i = 0; i < row_count_; ++i) {
      std::size_t& e = next[static_cast<std::size_t>(i)];
      const auto entries = EntriesOf(i);
      if (e == entries.size() || entries[e].place != t) continue;
      moved_.block(0, 3 * i, size, 3) += entries[e].weight * column_.topRows(size);
      ++e;
    }
  }
}

void RowResponses::FillRowCompliance() {
  for (int i = 0; i < row_count_; ++i) {
    const auto moved = moved_.middleCols<3>(3 * i);
    for (int j = 0; j <= i; ++j) {
      Matrix3d sum = Matrix3d::Zero();
      for (const Entry& entry : EntriesOf(j)) {
        sum += entry.weight * moved.middleRows<3>(3 * entry.place);
      }
      if (j == i) sum = ((sum + sum.transpose()) / 2).eval();
      row_compliance_.block<3, 3>(3 * j, 3 * i) = sum;
      row_compliance_.block<3, 3>(3 * i, 3 * j) = sum.transpose();
    }
  }
}

void RowResponses::AddCompliance(int body, double yield, ContactSolver* solver) {
  MoveRows();
  FillRowCompliance();
  for (const ContactSolver::Side& loaded : solver->sides(body)) {
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the sides of one row follow each other
    for (const ContactSolver::Side& side : solver->sides(body)) {
      if (side.row != at) {
        at = side.row;
        moved.noalias() = row_compliance_.block<3, 3>(3 * at, 3 * loaded.row) * loaded.force_W;
      }
      solver->AddCompliance(side.equation, loaded.equation, side.axis_W.dot(moved), yield);
    }
  }
}

void RowResponses::SetForces(int body, const ContactSolver& solver) {
  forces_.leftCols(count_).setZero();
  for (const ContactSolver::Side& side : solver.sides(body)) {
    const Vector3d force = solver.forces()[side.equation] * side.force_W;
    for (const Entry& entry : EntriesOf(side.row)) {
      forces_.col(entry.place) += entry.weight * force;
    }
  }
}

void RowResponses::Deform(Eigen::Ref<Eigen::VectorXd> u) const {
  u.setZero();
  for (int t = 0; t < count_; ++t) {
    const int a = touched_[static_cast<std::size_t>(t)];
    const auto f = forces_.col(t);
    const auto moved = inverse_->middleCols<3>(3 * a);
    if ((f.array() != 0).all()) {  // adds in the same order as below, in one pass
      u = u + f[0] * moved.col(0) + f[1] * moved.col(1) + f[2] * moved.col(2);
      continue;
    }
    for (int d = 0; d < 3; ++d) {
      if (f[d] != 0) u += f[d] * moved.col(d);
    }
  }
}

}  // namespace hpdm
