#include "engine/attachment/attachment_state.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstdio>
#include <string>
#include <utility>

#include "engine/base/error.h"

namespace hpdm {
namespace {

// A change of damage that does not change a step's forces.
constexpr double kSettled = 1e-4;

}  // namespace

AttachmentState::AttachmentState(std::shared_ptr<const AttachmentJoint> joint)
    : joint_(std::move(joint)),
      R_(3 * joint_->modes(), 3 * joint_->modes()),
      factor_(3 * joint_->modes(), 3 * joint_->modes()) {
  std::size_t count = 0;
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    count += static_cast<std::size_t>(layer.bed.size());
  }
  now_.damage.assign(count, 0);
  now_.torn = burnt_ = cut_ = now_.damage;
  now_.spared.assign(joint_->layers().size(), 0);
  now_.closed.assign(count, 0);
  for (const AttachmentJoint::Duct& duct : joint_->ducts()) {
    duct_unknowns_ += now_.ducts.emplace_back(duct.model).unknowns();
  }
  if (!now_.ducts.empty()) constant_.setZero(3 * joint_->modes());
  now_.taken_away.assign(joint_->layers().size(), 0);
  Refactor();
  if (joint_->sag().size() > 0) BearWeight();
}

// Finds what the undamaged layers bear, without the ducts. Refuses a layer that it would damage.
void AttachmentState::BearWeight() {
  const Eigen::MatrixXd& stiffness = joint_->lasting_stiffness();
  Eigen::MatrixXd held = stiffness;
  const Eigen::Index of_layers =
      3 * (joint_->ducts().empty() ? joint_->modes() : joint_->ducts()[0].first_mode);
  held.topLeftCorner(of_layers, of_layers) += R_.topLeftCorner(of_layers, of_layers);
  const Eigen::VectorXd w = held.ldlt().solve(Eigen::VectorXd(stiffness * joint_->sag()));
  borne_.resize(static_cast<Eigen::Index>(now_.damage.size()), 3);
  constant_.setZero(w.size());
  Eigen::Index at = 0;
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    const AttachmentBed& bed = layer.bed;
    for (int i = 0; i < bed.size(); ++i, ++at) {
      const Vector3d delta = DisplacementOf(layer, i, w);
      borne_.row(at) = delta.transpose();
      const double traction = bed.law.stiffness * bed.law.Effective(delta, bed.normals_W.row(i));
      if (traction <= bed.options.strength) continue;
      char text[240];
      const auto p_W = bed.points_W[0].row(i);
      std::snprintf(text, sizeof text,
                    "\": the weight that it bears loads it with %.3g Pa at [%.3f, %.3f, %.3f], "
                    "beyond its strength of %.3g Pa; give a larger one, a support or less gravity",
                    traction, p_W.x(), p_W.y(), p_W.z(), bed.options.strength);
      throw InputError("[[attachment]] of organs \"" + bed.options.a + "\" and \"" + bed.options.b +
                       text);
    }
  }
}

std::span<const double> AttachmentState::DamageOf(std::size_t layer) const {
  return damage().subspan(Number(layer, 0), ToSize(joint_->layers()[layer].bed.size()));
}

std::span<const double> AttachmentState::BurntOf(std::size_t layer) const {
  return std::span(burnt_).subspan(Number(layer, 0), ToSize(joint_->layers()[layer].bed.size()));
}

std::size_t AttachmentState::Number(std::size_t layer, int sample) const {
  std::size_t first = 0;
  for (std::size_t l = 0; l < layer; ++l) first += ToSize(joint_->layers()[l].bed.size());
  return first + ToSize(sample);
}

double AttachmentState::Left(std::size_t layer, int sample) const {
  const std::size_t at = Number(layer, sample);
  return now_.damage[at] >= 1 ? 0 : 1 - burnt_[at] - cut_[at];
}

double AttachmentState::Remove(std::size_t layer, int sample, double share,
                               std::vector<double>* by) {
  const std::size_t at = Number(layer, sample);
  const double left = Left(layer, sample);
  if (!(share > 0) || left == 0) return 0;
  share = std::min(share, left);
  (*by)[at] += share;
  now_.damage[at] = share == left ? 1 : DamageWith(now_.torn[at], burnt_[at] + cut_[at]);
  changed_ = true;
  return share;
}

bool AttachmentState::IsTorn(std::size_t layer) const {
  const std::span<const double> damage = DamageOf(layer);
  return std::all_of(damage.begin(), damage.end(), [](double d) { return d >= 1; });
}

void AttachmentState::TakeAway(std::size_t layer) {
  const auto first = static_cast<std::ptrdiff_t>(DamageOf(layer).data() - now_.damage.data());
  std::fill_n(now_.closed.begin() + first, joint_->layers()[layer].bed.size(), 0);
  now_.taken_away[layer] = 1;
  changed_ = true;
}

void AttachmentState::Refactor() {
  if (!changed_ && !ducts_changed_) return;
  if (changed_) AddLayers();
  AddDucts();
  Factor();
  changed_ = ducts_changed_ = false;
}

// Fills the layers' part of R and of the constant forces.
void AttachmentState::AddLayers() {
  R_.setZero();
  if (constant_.size() > 0) constant_.setZero();
  std::size_t first = 0;
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    const Eigen::Index s = layer.samples.rows(), at = 3 * layer.first_mode;
    auto block = R_.block(at, at, 3 * s, 3 * s);
    // Samples that are not closed respond alike along all axes: their sum along one, lower part.
    auto sum = factor_.topLeftCorner(s, s);
    sum.setZero();
    for (int i = 0; i < layer.bed.size(); ++i) {
      const double rest = layer.bed.areas[i] * (1 - now_.damage[first + ToSize(i)]);
      if (rest == 0) continue;
      const auto m = layer.samples.col(i);
      for (Eigen::Index l = 0; l < s; ++l) sum.col(l).tail(s - l) += rest * m[l] * m.tail(s - l);
    }
    sum *= layer.bed.law.stiffness;
    for (Eigen::Index l = 0; l < s; ++l) {
      for (Eigen::Index j = l; j < s; ++j) {
        const double value = sum(j, l);
        block.block<3, 3>(3 * j, 3 * l) = value * Matrix3d::Identity();
        block.block<3, 3>(3 * l, 3 * j) = value * Matrix3d::Identity();
      }
    }
    for (int i = 0; i < layer.bed.size(); ++i) {
      const double d = now_.damage[first + ToSize(i)];
      if (now_.closed[first + ToSize(i)] == 0 || d == 0) continue;
      const Vector3d n = layer.bed.normals_W.row(i);
      const Matrix3d along = layer.bed.areas[i] * d * layer.bed.law.stiffness * n * n.transpose();
      for (Eigen::Index l = 0; l < s; ++l) {
        for (Eigen::Index j = 0; j < s; ++j) {
          block.block<3, 3>(3 * j, 3 * l) += layer.samples(j, i) * layer.samples(l, i) * along;
        }
      }
    }
    for (int i = 0; i < layer.bed.size() && borne_.rows() > 0; ++i) {
      const auto sample = static_cast<Eigen::Index>(first) + i;
      const double d = now_.damage[ToSize(sample)];
      if (d == 0) continue;
      Vector3d lost = d * layer.bed.areas[i] * layer.bed.law.stiffness * borne_.row(sample);
      if (now_.closed[ToSize(sample)] != 0) {
        const Vector3d n = layer.bed.normals_W.row(i);
        lost -= n.dot(lost) * n;
      }
      for (Eigen::Index j = 0; j < s; ++j) {
        constant_.segment<3>(at + 3 * j) -= layer.samples(j, i) * lost;
      }
    }
    first += ToSize(layer.bed.size());
  }
}

void AttachmentState::AddDucts() {
  for (std::size_t d = 0; d < now_.ducts.size(); ++d) {
    const Eigen::Index at = 3 * joint_->ducts()[d].first_mode, count = now_.ducts[d].unknowns();
    R_.block(at, at, count, count) = now_.ducts[d].stiffness();
    constant_.segment(at, count) = now_.ducts[d].constant();
  }
}

// Factors G^-1 + R. If the layers are the same, only the ducts' rows change, the last ones. A duct
// under pressure can have negative stiffness: if the organs cannot hold it, that part is left out.
void AttachmentState::Factor() {
  const Eigen::Index kept = changed_ ? 0 : R_.rows() - duct_unknowns_, rest = R_.rows() - kept;
  if (rest == 0) return;
  for (int attempt = 0; attempt < 2; ++attempt) {
    auto corner = factor_.bottomRightCorner(rest, rest);
    corner = joint_->stiffness().bottomRightCorner(rest, rest) + R_.bottomRightCorner(rest, rest);
    for (Eigen::Index k = 0; k < kept; ++k) {
      const auto column = factor_.col(k).tail(rest);
      for (Eigen::Index j = 0; j < rest; ++j) corner.col(j) -= column[j] * column;
    }
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(corner);  // in place
    if (factor.info() == Eigen::Success) return;
    for (DuctState& duct : now_.ducts) duct.Stabilise();
    AddDucts();
  }
}

// A few columns at once, so that L passes through the processor once for them. Eigen's own solution of
// many columns allocates.
void AttachmentState::HalfSettle(Eigen::Ref<Eigen::MatrixXd> columns, FewColumns* scratch) const {
  auto few = scratch->topRows(columns.rows());
  for (Eigen::Index first = 0; first < columns.cols(); first += few.cols()) {
    const Eigen::Index count = std::min(few.cols(), columns.cols() - first);
    few.setZero();
    few.leftCols(count) = columns.middleCols(first, count);
    for (Eigen::Index j = 0; j < few.rows(); ++j) {
      few.row(j) /= factor_(j, j);
      const Eigen::Matrix<double, 1, FewColumns::ColsAtCompileTime> solved = few.row(j);
      for (Eigen::Index i = j + 1; i < few.rows(); ++i) few.row(i) -= factor_(i, j) * solved;
    }
    columns.middleCols(first, count) = few.leftCols(count);
  }
}

void AttachmentState::Settle(Eigen::Ref<Eigen::VectorXd> w) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(w);
  factor_.transpose().triangularView<Eigen::Upper>().solveInPlace(w);
}

Vector3d AttachmentState::DisplacementOf(const AttachmentJoint::Layer& layer, int sample,
                                         const Eigen::VectorXd& w) const {
  Vector3d delta = Vector3d::Zero();
  for (Eigen::Index j = 0; j < layer.samples.rows(); ++j) {
    delta += layer.samples(j, sample) * w.segment<3>(3 * (layer.first_mode + j));
  }
  return delta;
}

bool AttachmentState::Update(const Eigen::VectorXd& w) {
  bool settled = true;
  std::size_t at = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    if (now_.taken_away[l] != 0) {
      at += ToSize(layer.bed.size());
      continue;
    }
    const CohesiveLaw& law = layer.bed.law;
    for (int i = 0; i < layer.bed.size(); ++i, ++at) {
      const Vector3d delta = DisplacementOf(layer, i, w) + BorneBy(at);
      const Vector3d normal = layer.bed.normals_W.row(i);
      const double torn = law.Damage(law.Effective(delta, normal));
      if (torn > now_.torn[at] && now_.damage[at] < 1) {
        const double removed = burnt_[at] + cut_[at], damage = DamageWith(torn, removed);
        if (removed > 0) {
          now_.spared[l] +=
              layer.bed.areas[i] * removed * (law.Dissipated(torn) - law.Dissipated(now_.torn[at]));
        }
        settled = settled && damage - now_.damage[at] <= kSettled;
        now_.torn[at] = torn;
        now_.damage[at] = damage;
        changed_ = true;
      }
      const char closed = law.Closed(delta, normal) ? 1 : 0;
      if (closed == now_.closed[at]) continue;
      now_.closed[at] = closed;
      if (now_.damage[at] == 0) continue;
      settled = false;
      changed_ = true;
    }
  }
  return MoveDucts(w) && settled;
}

bool AttachmentState::MoveDucts(const Eigen::VectorXd& w) {
  bool settled = true;
  for (std::size_t d = 0; d < now_.ducts.size(); ++d) {
    DuctState& duct = now_.ducts[d];
    settled = duct.Follow(w.segment(3 * joint_->ducts()[d].first_mode, duct.unknowns())) && settled;
    ducts_changed_ = true;
  }
  return settled;
}

void AttachmentState::TakeBack(const Solved& kept) {
  now_ = kept;
  changed_ = ducts_changed_ = true;
}

void AttachmentState::Report(const Eigen::VectorXd& w,
                             std::span<AttachmentOutcome> outcomes) const {
  std::size_t at = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    AttachmentOutcome& outcome = outcomes[l];
    outcome = {};
    for (int i = 0; i < layer.bed.size(); ++i, ++at) {
      const double area = layer.bed.areas[i], d = now_.damage[at], k = layer.bed.law.stiffness;
      const Vector3d delta = DisplacementOf(layer, i, w) + BorneBy(at);
      const Vector3d n = layer.bed.normals_W.row(i);
      outcome.load_W -= area * (1 - d) * k * delta;
      if (now_.closed[at] != 0) outcome.load_W -= area * d * k * n.dot(delta) * n;
      outcome.largest_damage = std::max(outcome.largest_damage, d);
      outcome.dissipated += area * layer.bed.law.Dissipated(now_.torn[at]);
      if (d < 1) continue;
      outcome.freed_area += area;
      outcome.burnt_area += area * burnt_[at];
      outcome.cut_area += area * cut_[at];
    }
    outcome.dissipated -= now_.spared[l];
  }
}

}  // namespace hpdm
