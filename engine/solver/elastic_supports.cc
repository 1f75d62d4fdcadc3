#include "engine/solver/elastic_supports.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

// Eigenvalues of the springs below this share of the largest are round-off.
constexpr double kLeastSpring = 1e-12;

// Returns L with L L^T the springs of the held control points; they have few columns where many
// control points share few springs.
Eigen::MatrixXd RootOf(const ScalarStiffness& springs, const std::vector<int>& held) {
  const auto count = static_cast<Eigen::Index>(held.size());
  Eigen::MatrixXd S(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      S(i, j) = springs.coeff(held[static_cast<std::size_t>(i)], held[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(S);
  const Eigen::VectorXd& values = solver.eigenvalues();  // ascending
  Eigen::Index dropped = 0;
  while (dropped < count && values[dropped] <= kLeastSpring * values[count - 1]) ++dropped;
  return solver.eigenvectors().rightCols(count - dropped) *
         values.tail(count - dropped).cwiseSqrt().asDiagonal();
}

std::vector<int> HeldBy(const ScalarStiffness& springs) {
  std::vector<int> held;
  for (int a = 0; a < springs.outerSize(); ++a) {
    for (ScalarStiffness::InnerIterator it(springs, a); it; ++it) {
      if (it.value() == 0) continue;
      held.push_back(a);
      break;
    }
  }
  return held;
}

}  // namespace

ElasticSupports::ElasticSupports(const LatticeCompliance& lattice, const ScalarStiffness& springs,
                                 Eigen::Index rows)
    : lattice_(&lattice), n_(springs.rows()), held_(HeldBy(springs)), U_bar_(3 * n_) {
  if (held_.empty()) return;
  const Eigen::MatrixXd root = RootOf(springs, held_);
  const auto count = static_cast<Eigen::Index>(held_.size());
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(3 * count, 3 * root.cols());
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < root.cols(); ++j) {
      L.block<3, 3>(3 * i, 3 * j) = root(i, j) * Matrix3d::Identity();
    }
  }
  const auto at_held = [&](Eigen::Index i) { return 3 * held_[static_cast<std::size_t>(i)]; };
  Eigen::MatrixXd response = Eigen::MatrixXd::Zero(3 * rows, L.cols());  // K^-1 L
  for (Eigen::Index i = 0; i < count; ++i) {
    response.middleRows<3>(at_held(i)) = L.middleRows<3>(3 * i);
  }
  lattice.SolveLoads(response);
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(L.cols(), L.cols());  // L^T K^-1 L
  for (Eigen::Index i = 0; i < count; ++i) {
    G.noalias() += L.middleRows<3>(3 * i).transpose() * response.middleRows<3>(at_held(i));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((G + G.transpose()) / 2);
  Eigen::Index dropped = 0;
  while (dropped < G.cols() && solver.eigenvalues()[dropped] < kLeastShare) ++dropped;
  const Eigen::Index kept = G.cols() - dropped;
  shares_ = solver.eigenvalues().tail(kept).cwiseMin(1);
  const Eigen::MatrixXd scaled =
      solver.eigenvectors().rightCols(kept) * shares_.cwiseSqrt().cwiseInverse().asDiagonal();
  modes_ = response.topRows(3 * n_) * scaled;
  loads_ = L * scaled;
  rows_.resize(kept, 3 * kMaxContacts);
  along_.resize(kept, ContactSolver::kMaxEquations);
  moved_.resize(kept, ContactSolver::kMaxEquations);
  amounts_.resize(kept);
  point_.resize(kept, 3);
}

double ElasticSupports::Further(Eigen::Index mode, double c) const {
  const double sigma = shares_[mode];
  return c * sigma / ((1 + c * (1 - sigma)) * (1 + c));
}

Eigen::VectorXd& ElasticSupports::AmountsOf(const Eigen::Ref<const Eigen::VectorXd>& U) const {
  U_bar_ = U.head(3 * n_);
  lattice_->AddLocalPart(U.tail(U.size() - 3 * n_), U_bar_);
  amounts_.setZero();
  for (std::size_t i = 0; i < held_.size(); ++i) {
    amounts_.noalias() += loads_.middleRows<3>(3 * static_cast<Eigen::Index>(i)).transpose() *
                          U_bar_.segment<3>(3 * held_[i]);
  }
  return amounts_;
}

void ElasticSupports::AddFree(double c, const Points& from, Points* free) const {
  Eigen::VectorXd& amounts = AmountsOf(Eigen::Map<const Eigen::VectorXd>(from.data(), from.size()));
  for (Eigen::Index j = 0; j < modes(); ++j) {
    const double moving = c * (1 - shares_[j]);
    amounts[j] *= moving / (1 + moving) - c / (1 + c);
  }
  AddModes(amounts, free);
}

void ElasticSupports::TakeOut(Points* U) const {
  Eigen::VectorXd& amounts = AmountsOf(Eigen::Map<const Eigen::VectorXd>(U->data(), U->size()));
  amounts.array() *= -shares_.array();
  AddModes(amounts, U);
}

void ElasticSupports::AddModes(const Eigen::VectorXd& amounts, Points* U) const {
  Eigen::Map<Eigen::VectorXd>(U->data(), 3 * n_).noalias() += modes_ * amounts;
}

void ElasticSupports::AddCompliance(int body, const ContactConstraints& contacts, double c,
                                    ContactSolver* solver) {
  for (int i = 0; i < contacts.size(); ++i) {
    auto row = rows_.middleCols<3>(3 * i);
    row.setZero();
    for (Eigen::Index a = 0; a < n_; ++a) {
      const double weight = contacts.Weights()(i, a);
      if (weight != 0) row += weight * modes_.middleRows<3>(3 * a).transpose();
    }
  }
  const std::span<const ContactSolver::Side> sides = solver->sides(body);
  for (std::size_t s = 0; s < sides.size(); ++s) {
    const auto column = static_cast<Eigen::Index>(s);
    const auto row = rows_.middleCols<3>(3 * sides[s].row);
    along_.col(column).noalias() = row * sides[s].axis_W;
    moved_.col(column).noalias() = row * sides[s].force_W;
    for (Eigen::Index j = 0; j < modes(); ++j) moved_(j, column) *= Further(j, c);
  }
  for (std::size_t e = 0; e < sides.size(); ++e) {
    for (std::size_t g = 0; g < sides.size(); ++g) {
      solver->compliance()(sides[e].equation, sides[g].equation) +=
          along_.col(static_cast<Eigen::Index>(e)).dot(moved_.col(static_cast<Eigen::Index>(g)));
    }
  }
}

void ElasticSupports::AddDisplacements(int body, double c, const ContactSolver& solver,
                                       Points* U) const {
  amounts_.setZero();
  for (const ContactSolver::Side& side : solver.sides(body)) {
    const Vector3d force = solver.forces()[side.equation] * side.force_W;
    amounts_.noalias() += rows_.middleCols<3>(3 * side.row) * force;
  }
  for (Eigen::Index j = 0; j < modes(); ++j) amounts_[j] *= Further(j, c);
  AddModes(amounts_, U);
}

Matrix3d ElasticSupports::InSeries(double R) const {
  Matrix3d sum = Matrix3d::Zero();
  for (Eigen::Index j = 0; j < modes(); ++j) {
    const Vector3d moved = point_.row(j);
    sum += shares_[j] / (1 + R * (1 - shares_[j])) * moved * moved.transpose();
  }
  return sum;
}

Matrix3d ElasticSupports::InSeries(const Eigen::Ref<const Eigen::MatrixXd>& response,
                                   double R) const {
  for (int d = 0; d < 3; ++d) point_.col(d) = AmountsOf(response.col(d));
  return InSeries(R);
}

Matrix3d ElasticSupports::InSeries(const SparseRow& b, double R) const {
  point_.setZero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    point_ += b.weights[i] * modes_.middleRows<3>(3 * b.control_points[i]).transpose();
  }
  return InSeries(R);
}

}  // namespace hpdm
