#include "engine/duct/rod.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr double kLargestTurn = 0.4;  // of a segment in one iteration
constexpr int kHalvings = 8;
constexpr double kSufficient = 1e-4;  // share of the slope by which the energy must fall
// Tolerance of a node's force, as shares of EI / L^2 and of EA.
constexpr double kOfBending = 1e-6, kOfTension = 1e-10;
// Drag of a part that nothing holds, as a share of EI / L^3 and EI / L.
constexpr double kDrag = 1e-3;
constexpr double kLeastStretch = 1e-6;

Matrix3d Cross(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// Returns 2 tan(angle / 2) axis of a rotation.
Vector3d HalfTangent(const Matrix3d& Q) {
  const Eigen::Quaterniond q(Q);
  return 2 * q.vec() / q.w();
}

// Its derivative by a rotation of the second frame, in that frame.
Matrix3d HalfTangentSlope(const Vector3d& c) {
  return Matrix3d::Identity() + Cross(c) / 2 + c * c.transpose() / 4;
}

// Keeps products of rotations orthonormal.
Matrix3d Orthonormal(const Matrix3d& R) {
  return R * (3 * Matrix3d::Identity() - R.transpose() * R) / 2;
}

}  // namespace

Matrix3d RotationOf(const Vector3d& v) {
  const double angle2 = v.squaredNorm();
  const Matrix3d V = Cross(v);
  if (angle2 < 1e-16) return Matrix3d::Identity() + V + V * V / 2;
  const double angle = std::sqrt(angle2);
  return Matrix3d::Identity() + std::sin(angle) / angle * V +
         (1 - std::cos(angle)) / angle2 * V * V;
}

Vector3d RotationVector(const Matrix3d& R) {
  Eigen::Quaterniond q(R);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2 * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Rod::Rod(const Points& path_W, const TubeSection& section)
    : section_(section),
      stations_(ToSize(path_W.rows()) + kMaxCuts),
      count_(ToSize(path_W.rows())),
      tangent_(2 * stations_.size() + 1),
      factor_(2 * stations_.size() + 1),
      fixed_(2 * stations_.size() + 1),
      loose_(stations_.size()),
      gradient_(2 * stations_.size() + 1, Vector3d::Zero()),
      step_(gradient_),
      columns_(gradient_.size()),
      node_columns_(gradient_.size()),
      kept_x_(stations_.size()),
      kept_R_(stations_.size()) {
  HPDM_CHECK(path_W.rows() >= 5);
  Matrix3d R_W = Matrix3d::Identity();
  double arc = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    Station& station = stations_[i];
    const auto row = static_cast<Eigen::Index>(i);
    station.rest_W = path_W.row(row);
    station.arc = arc;
    if (i + 1 < count_) {
      const Vector3d way_W = (path_W.row(row + 1) - path_W.row(row)).transpose();
      station.length = way_W.norm();
      // Each frame is the last one turned without twist.
      const Vector3d before_W = R_W.col(2);
      R_W = Eigen::Quaterniond::FromTwoVectors(before_W, way_W).toRotationMatrix() * R_W;
      arc += station.length;
    }
    station.rest_R_W = R_W;
  }
  rest_length_ = arc;
  rest_ends_ = {Frame{stations_[0].rest_W, stations_[0].rest_R_W},
                Frame{stations_[count_ - 1].rest_W, R_W}};
  tolerance_ = kOfBending * section.bending / (arc * arc) + kOfTension * section.axial;
  drag_ = kDrag * section.bending / (arc * arc * arc);
  turn_drag_ = kDrag * section.bending / arc;
  for (std::size_t i = 0; i < count_; ++i) {
    Station& station = stations_[i];
    const double before = i == 0 ? 0 : stations_[i - 1].length;
    const double after = i + 1 == count_ ? 0 : station.length;
    station.bend_length = (before + after) / 2;
  }
  Reset();
  for (std::size_t i = 0; i < count_; ++i) {
    stations_[i].rest_bend = HalfTangent(Before(i).transpose() * After(i));
  }
}

void Rod::Reset() {
  for (std::size_t i = 0; i < count_; ++i) {
    stations_[i].x_W = stations_[i].rest_W;
    stations_[i].R_W = stations_[i].rest_R_W;
  }
  ends_ = rest_ends_;
}

void Rod::Hold(int node, const Vector3d& target_W) {
  stations_[ToSize(node)].held = true;
  stations_[ToSize(node)].target_W = target_W;
}

bool Rod::HoldsNode() const {
  for (std::size_t i = 0; i < count_; ++i) {
    if (stations_[i].held) return true;
  }
  return false;
}

bool Rod::Cut(int node) {
  const std::size_t k = ToSize(node);
  if (cuts_ == kMaxCuts || k < 2 || k + 2 >= count_) return false;
  for (std::size_t i = k - 2; i <= k + 1; ++i) {
    if (stations_[i].gap) return false;
  }
  ++cuts_;
  ++count_;
  for (std::size_t i = count_ - 1; i > k; --i) stations_[i] = stations_[i - 1];
  stations_[k].gap = true;
  stations_[k].stiffer = 1;
  stations_[k].force_W.setZero();
  stations_[k].held = false;
  return true;
}

// d: from node to node, over the length at rest.
double Rod::StrainEnergy(const Vector3d& d, const Vector3d& r) const {
  const double stretch = d.norm();
  return section_.axial / 2 * (stretch - 1) * (stretch - 1) +
         section_.across * stretch * (stretch - r.dot(d));
}

// Its derivative by d, N.
Vector3d Rod::StrainForce(const Vector3d& d, const Vector3d& r) const {
  const double stretch = std::max(d.norm(), kLeastStretch);
  const Vector3d u = d / stretch;
  return section_.axial * (stretch - 1) * u +
         section_.across * (2 * d - r.dot(d) * u - stretch * r);
}

Vector3d Rod::ForceIn(int i) const {
  const Station& station = stations_[ToSize(i)];
  if (station.gap) return Vector3d::Zero();
  const Vector3d d = (stations_[ToSize(i) + 1].x_W - station.x_W) / station.length;
  return station.R_W.transpose() * StrainForce(d, station.R_W.col(2));
}

// True if the node ties the segments beside it, or an end's frame and the segment there.
bool Rod::Bends(std::size_t i) const {
  if (i > 0 && stations_[i - 1].gap) return false;
  if (i + 1 == count_) return !last_free_;
  return !stations_[i].gap;
}

// Two halves in series.
Vector3d Rod::BendingStiffness(std::size_t i) const {
  const double before = i == 0 ? stations_[0].stiffer : stations_[i - 1].stiffer;
  const double after = i + 1 == count_ ? before : stations_[i].stiffer;
  const double factor = 2 * before * after / (before + after);
  return factor * Vector3d(section_.bending, section_.bending, section_.torsion);
}

// Marks the blocks that do not move by themselves, and the nodes of parts that no end holds.
void Rod::Mark() {
  std::fill(fixed_.begin(), fixed_.end(), char{0});
  fixed_[0] = fixed_[X(0)] = fixed_[blocks() - 1] = 1;
  if (!last_free_) fixed_[X(nodes() - 1)] = 1;
  for (int i = 0; i < nodes(); ++i) {
    if (stations_[ToSize(i)].held) fixed_[X(i)] = 1;
    if (i + 1 < nodes() && stations_[ToSize(i)].gap) fixed_[T(i)] = 1;
  }
  std::size_t first = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool last = i + 1 == count_;
    if (!last && !stations_[i].gap) continue;
    const bool held = first == 0 || (last && !last_free_);
    std::fill(loose_.begin() + static_cast<std::ptrdiff_t>(first),
              loose_.begin() + static_cast<std::ptrdiff_t>(i + 1), held ? char{0} : char{1});
    first = i + 1;
  }
}

double Rod::Energy() const {
  double energy = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Station& station = stations_[i];
    energy -= station.force_W.dot(station.x_W - station.rest_W);
    if (i + 1 < count_ && !station.gap) {
      const Vector3d d = (stations_[i + 1].x_W - station.x_W) / station.length;
      energy += station.length * StrainEnergy(d, station.R_W.col(2));
    }
    if (Bends(i)) {
      const Vector3d bend = HalfTangent(Before(i).transpose() * After(i)) - station.rest_bend;
      energy += 0.5 / station.bend_length * bend.dot(BendingStiffness(i).cwiseProduct(bend));
    }
  }
  return energy;
}

// Fills gradient and tangent. Without its geometric part the tangent has no negative eigenvalue.
void Rod::Assemble(bool geometric) {
  tangent_.SetZero(blocks());
  for (std::size_t b = 0; b < blocks(); ++b) gradient_[b].setZero();
  for (std::size_t i = 0; i < count_; ++i) {
    gradient_[X(static_cast<int>(i))] -= stations_[i].force_W;
    if (i + 1 < count_ && !stations_[i].gap) AssembleSegment(i, geometric);
    if (Bends(i)) AssembleBend(i, geometric);
    if (loose_[i] == 0) continue;
    const int node = static_cast<int>(i);
    tangent_.At(X(node), X(node)).diagonal().array() += drag_;
    if (i + 1 < count_) tangent_.At(T(node), T(node)).diagonal().array() += turn_drag_;
  }
}

void Rod::AssembleSegment(std::size_t i, bool geometric) {
  const Station& station = stations_[i];
  const std::size_t a = 1 + 2 * i, t = a + 1, b = a + 2;
  const double l = station.length;
  const Vector3d d = (stations_[i + 1].x_W - station.x_W) / l;
  const Vector3d r = station.R_W.col(2);
  const Vector3d N = StrainForce(d, r);
  gradient_[b] += N;
  gradient_[a] -= N;
  gradient_[t] += l * N.cross(d);
  // Without the forces' own part: s I + (e - s) r r^T, positive definite.
  const double s = section_.across, e = section_.axial;
  const Matrix3d I = Matrix3d::Identity();
  Matrix3d C = s * I + (e - s) * r * r.transpose();
  Matrix3d mixed = C * Cross(d);
  Matrix3d turn = l * Cross(d).transpose() * mixed;
  if (geometric) {
    const double stretch = std::max(d.norm(), kLeastStretch);
    const Vector3d u = d / stretch;
    const Matrix3d across = I - u * u.transpose();
    C = e * (I - across / stretch) +
        s * (2 * I - u * r.transpose() - r * u.transpose() - r.dot(d) / stretch * across);
    mixed = s * (stretch * Cross(r) - u * r.cross(d).transpose());
    turn = s * stretch * l * (r.dot(d) * I - (r * d.transpose() + d * r.transpose()) / 2);
  }
  tangent_.At(a, a) += C / l;
  tangent_.At(b, b) += C / l;
  tangent_.At(b, a) -= C / l;
  tangent_.At(t, a) -= mixed.transpose();
  tangent_.At(b, t) += mixed;
  tangent_.At(t, t) += turn;
}

void Rod::AssembleBend(std::size_t i, bool geometric) {
  const std::size_t p = 2 * i, n = p + 2;  // the rotations before and after the node
  const Station& station = stations_[i];
  const Matrix3d& R = After(i);
  const Vector3d c = HalfTangent(Before(i).transpose() * R);
  const Vector3d stiffness = BendingStiffness(i) / station.bend_length;
  const Matrix3d B = HalfTangentSlope(c) * R.transpose();
  const Vector3d M = B.transpose() * stiffness.cwiseProduct(c - station.rest_bend);
  gradient_[n] += M;
  gradient_[p] -= M;
  const Matrix3d H = B.transpose() * stiffness.asDiagonal() * B;
  tangent_.At(p, p) += H;
  tangent_.At(n, n) += H;
  tangent_.At(n, p) -= H;
  if (geometric) tangent_.At(n, p) -= Cross(M) / 2;
}

// Factors the free blocks' part of the tangent.
bool Rod::FactorFree() {
  factor_.SetZero(blocks());
  for (std::size_t j = 0; j < blocks(); ++j) {
    if (fixed_[j] != 0) {
      factor_.At(j, j).setIdentity();
      continue;
    }
    for (std::size_t i = j; i <= j + BlockBand::kBeside && i < blocks(); ++i) {
      if (fixed_[i] == 0) factor_.At(i, j) = tangent_.At(i, j);
    }
  }
  return factor_.Factor();
}

// Factors the tangent, without its geometric part if it is not positive definite. Round-off of a part
// that hardly anything holds is met by a larger diagonal, a shape that is not finite by the identity.
void Rod::FactorStable() {
  if (FactorFree()) return;
  Assemble(false);
  for (double share = 1e-12; !FactorFree(); share *= 1e3) {
    if (!(share < 1)) {
      factor_.SetZero(blocks());
      for (std::size_t j = 0; j < blocks(); ++j) factor_.At(j, j).setIdentity();
      return;
    }
    for (std::size_t j = 0; j < blocks(); ++j) {
      tangent_.At(j, j).diagonal().array() += share * tangent_.At(j, j).trace();
    }
  }
}

double Rod::Residual() const {
  double largest = 0;
  for (std::size_t b = 0; b < blocks(); ++b) {
    if (fixed_[b] != 0) continue;
    const double unit = b % 2 == 1 ? 1 : stations_[0].length;  // moments over a segment's length
    largest = std::max(largest, gradient_[b].cwiseAbs().maxCoeff() / unit);
  }
  return largest;
}

// Fills the steps of the blocks that are moved from outside. False if none of them moves.
bool Rod::FindIncrements(const std::array<Frame, 2>& ends) {
  for (std::size_t b = 0; b < blocks(); ++b) step_[b].setZero();
  bool moves = false;
  const auto set = [&](std::size_t block, const Vector3d& way) {
    step_[block] = way;
    moves = moves || !way.isZero(0);
  };
  const auto turn = [&](std::size_t block, const Matrix3d& to_W, const Matrix3d& from_W) {
    if (to_W != from_W) set(block, RotationVector(to_W * from_W.transpose()));
  };
  turn(0, ends[0].R_W, ends_[0].R_W);
  set(X(0), ends[0].p_W - stations_[0].x_W);
  if (!last_free_) {
    turn(blocks() - 1, ends[1].R_W, ends_[1].R_W);
    set(X(nodes() - 1), ends[1].p_W - stations_[count_ - 1].x_W);
  }
  for (int i = 1; i + 1 < nodes(); ++i) {
    if (stations_[ToSize(i)].held) {
      set(X(i), stations_[ToSize(i)].target_W - stations_[ToSize(i)].x_W);
    }
  }
  return moves;
}

// Solves for the free blocks' steps, with the others' given. Returns the energy's slope along them.
double Rod::SolveStep() {
  for (std::size_t b = 0; b < blocks(); ++b) {
    if (fixed_[b] == 0) step_[b] = -gradient_[b];
  }
  for (std::size_t j = 0; j < blocks(); ++j) {
    for (std::size_t i = j + 1; i <= j + BlockBand::kBeside && i < blocks(); ++i) {
      if (fixed_[i] == fixed_[j]) continue;
      if (fixed_[j] != 0) step_[i].noalias() -= tangent_.At(i, j) * step_[j];
      if (fixed_[i] != 0) step_[j].noalias() -= tangent_.At(i, j).transpose() * step_[i];
    }
  }
  // A fixed block's row and column of the factor are those of the identity.
  factor_.SolveForward(&step_);
  factor_.SolveBackward(&step_);
  double slope = 0;
  for (std::size_t b = 0; b < blocks(); ++b) slope += gradient_[b].dot(step_[b]);
  return slope;
}

void Rod::Move(double share) {
  const auto turned = [&](const Matrix3d& R, std::size_t block) -> Matrix3d {
    return step_[block].isZero(0) ? R : Orthonormal(RotationOf(share * step_[block]) * R);
  };
  ends_[0].R_W = turned(ends_[0].R_W, 0);
  ends_[1].R_W = turned(ends_[1].R_W, blocks() - 1);
  for (int i = 0; i < nodes(); ++i) {
    Station& station = stations_[ToSize(i)];
    station.x_W += share * step_[X(i)];
    if (i + 1 < nodes()) station.R_W = turned(station.R_W, T(i));
  }
  ends_[0].p_W = stations_[0].x_W;
  ends_[1].p_W = stations_[count_ - 1].x_W;
}

void Rod::Keep() {
  for (std::size_t i = 0; i < count_; ++i) {
    kept_x_[i] = stations_[i].x_W;
    kept_R_[i] = stations_[i].R_W;
  }
}

// Moves along the steps until the energy has fallen enough.
void Rod::Search(double slope, double before) {
  Keep();
  double largest = 0;
  for (std::size_t b = 0; b < blocks(); b += 2) largest = std::max(largest, step_[b].norm());
  double share = largest > kLargestTurn ? kLargestTurn / largest : 1;
  const double rounding = 1e-13 * std::abs(before);
  for (int halving = 0; halving <= kHalvings; ++halving, share /= 2) {
    Move(share);
    if (Energy() <= before + kSufficient * share * slope + rounding) return;
    for (std::size_t i = 0; i < count_; ++i) {
      stations_[i].x_W = kept_x_[i];
      stations_[i].R_W = kept_R_[i];
    }
  }
  Move(share);
}

Rod::Result Rod::Settle(const std::array<Frame, 2>& ends) {
  Result result;
  Mark();
  for (;; ++result.iterations) {
    Assemble(true);
    const bool moves = FindIncrements(ends);
    result.residual = Residual();
    result.converged = !moves && result.residual <= tolerance_;
    if (result.converged || result.iterations == kMaxIterations) break;
    FactorStable();
    const double slope = SolveStep();
    if (!moves) {
      Search(slope, Energy());
      continue;
    }
    double largest = 0;
    for (std::size_t b = 0; b < blocks(); b += 2) largest = std::max(largest, step_[b].norm());
    if (largest > kLargestTurn) {
      Move(kLargestTurn / largest);
      continue;
    }
    Move(1);
    // The last bits too: an end at rest gives the shape at rest.
    stations_[0].x_W = ends[0].p_W;
    if (!last_free_) stations_[count_ - 1].x_W = ends[1].p_W;
    ends_[0] = ends[0];
    if (!last_free_) ends_[1] = ends[1];
    for (std::size_t i = 0; i < count_; ++i) {
      if (stations_[i].held) stations_[i].x_W = stations_[i].target_W;
    }
  }
  return result;
}

void Rod::Condense(EndVector* gradient, EndMatrix* stiffness) {
  const std::size_t last = blocks() - 1;
  const std::array<std::size_t, 4> of_ends{X(0), 0, last - 1, last};
  FactorStable();
  for (std::size_t b = 0; b < blocks(); ++b) columns_[b].setZero();
  stiffness->setZero();
  for (int g = 0; g < 4; ++g) {
    const std::size_t e = of_ends[ToSize(g)];
    const bool free_end = last_free_ && g >= 2;
    gradient->segment<3>(3 * g) = free_end ? Vector3d::Zero() : gradient_[e];
    if (free_end) continue;
    stiffness->block<3, 3>(3 * g, 3 * g) = tangent_.At(e, e);
    for (std::size_t i = e < 2 ? 0 : e - 2; i <= e + 2 && i <= last; ++i) {
      if (fixed_[i] != 0) continue;
      auto column = columns_[i].middleCols<3>(3 * g);
      if (i > e) column = tangent_.At(i, e);
      if (i < e) column = tangent_.At(e, i).transpose();
    }
  }
  factor_.SolveForward(&columns_);
  for (std::size_t b = 0; b < blocks(); ++b) {
    if (fixed_[b] == 0) stiffness->noalias() -= columns_[b].transpose() * columns_[b];
  }
}

Rod::NodeStiffness Rod::StiffnessOf(int node) {
  const std::size_t e = X(node);
  NodeStiffness stiffness;
  stiffness.node = tangent_.At(e, e);
  for (std::size_t b = 0; b < blocks(); ++b) node_columns_[b].setZero();
  for (std::size_t i = e - 2; i <= e + 2; ++i) {
    if (fixed_[i] != 0) continue;
    if (i > e) node_columns_[i] = tangent_.At(i, e);
    if (i < e) node_columns_[i] = tangent_.At(e, i).transpose();
  }
  factor_.SolveForward(&node_columns_);
  for (std::size_t b = 0; b < blocks(); ++b) {
    if (fixed_[b] != 0) continue;
    stiffness.node.noalias() -= node_columns_[b].transpose() * node_columns_[b];
    stiffness.ends.noalias() -= columns_[b].transpose() * node_columns_[b];
  }
  return stiffness;
}

}  // namespace hpdm
