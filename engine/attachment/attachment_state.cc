#include "engine/attachment/attachment_state.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "engine/base/error.h"

namespace hpdm {
namespace {

// A change of damage that does not change a step's forces.
constexpr double kSettled = 1e-4;
// The largest change of a sample's damage that is not taken into R within a step.
constexpr double kMostDeferred = 0.02;

// Returns a sample's stiffness, Pa/m.
Matrix3d StiffnessOf(const AttachmentBed& bed, int sample, double damage, bool closed) {
  const Vector3d n = bed.normals_W.row(sample);
  return bed.law.Alike(damage) * Matrix3d::Identity() +
         bed.law.BesideAlike(damage, closed) * n * n.transpose();
}

}  // namespace

AttachmentState::AttachmentState(std::shared_ptr<const AttachmentJoint> joint)
    : joint_(std::move(joint)),
      solver_(joint_),
      constant_(Eigen::VectorXd::Zero(3 * joint_->modes())),
      changed_(joint_->layers().size(), 1) {
  std::size_t count = 0;
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    count += static_cast<std::size_t>(layer.bed.size());
  }
  now_.damage.assign(count, 0);
  now_.torn = burnt_ = cut_ = now_.damage;
  now_.spared.assign(joint_->layers().size(), 0);
  now_.closed.assign(count, 0);
  for (const AttachmentJoint::Duct& duct : joint_->ducts()) {
    now_.ducts.emplace_back(duct.model);
  }
  now_.taken_away.assign(joint_->layers().size(), 0);
  AddLayers();  // also without layers: the ducts follow them
  std::ranges::fill(changed_, 0);
  Refactor();
  if (joint_->sag().size() > 0) BearWeight();
}

// Finds what the undamaged layers bear, without the ducts; leaves bear nothing, since they are slack in
// one direction. Refuses a layer that the weight would damage.
void AttachmentState::BearWeight() {
  const Eigen::MatrixXd G = joint_->LastingCompliance();
  Eigen::MatrixXd held = Eigen::MatrixXd::Identity(G.rows(), G.cols());  // 1 + G R
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    if (layer.bed.law.leaf) continue;
    const Eigen::Index first = 3 * layer.first_mode, size = 3 * layer.samples.rows();
    held.middleCols(first, size) += G.middleCols(first, size) * solver_.StiffnessOf(l);
  }
  const Eigen::VectorXd w = held.partialPivLu().solve(joint_->sag());
  borne_.setZero(static_cast<Eigen::Index>(now_.damage.size()), 3);
  Eigen::Index at = 0;
  for (const AttachmentJoint::Layer& layer : joint_->layers()) {
    const AttachmentBed& bed = layer.bed;
    for (int i = 0; i < bed.size(); ++i, ++at) {
      if (bed.law.leaf) continue;
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
  changed_[layer] = 1;
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
  changed_[layer] = 1;
}

void AttachmentState::Refactor() {
  const bool changed = std::ranges::find(changed_, 1) != changed_.end();
  if (!changed && !ducts_changed_) return;
  if (changed) AddLayers();
  AddConstants();
  AddDucts();
  std::ranges::fill(changed_, 0);
}

void AttachmentState::AddDucts() {
  solver_.TakeDucts(now_.ducts);
  for (std::size_t d = 0; d < now_.ducts.size(); ++d) {
    const Eigen::Index at = 3 * joint_->ducts()[d].first_mode;
    constant_.segment(at, now_.ducts[d].unknowns()) = now_.ducts[d].constant();
  }
  ducts_changed_ = false;
}

void AttachmentState::RefactorOrDefer(const Eigen::VectorXd& w) {
  for (std::size_t i = 0; i < now_.damage.size(); ++i) {
    const double d = now_.damage[i], d_0 = factored_damage_[i];
    const bool flipped = d_0 > 0 && now_.closed[i] != factored_closed_[i];
    if (flipped || d - d_0 > kMostDeferred || (d >= 1 && d_0 < 1)) return Refactor();
  }
  AddConstants();
  AddDeferred(w);
  AddDucts();
}

// Adds the forces at w of what has changed since R was factored.
void AttachmentState::AddDeferred(const Eigen::VectorXd& w) {
  std::size_t at = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    for (int i = 0; i < layer.bed.size(); ++i, ++at) {
      const double d = now_.damage[at], d_0 = factored_damage_[at];
      const bool closed = now_.closed[at] != 0, closed_0 = factored_closed_[at] != 0;
      if (d == d_0 && closed == closed_0) continue;
      const Matrix3d change =
          StiffnessOf(layer.bed, i, d, closed) - StiffnessOf(layer.bed, i, d_0, closed_0);
      AddConstant(layer, i, layer.bed.areas[i] * (change * DisplacementOf(layer, i, w)));
    }
  }
}

void AttachmentState::AddConstant(const AttachmentJoint::Layer& layer, int sample,
                                  const Vector3d& force_W) {
  for (Eigen::Index j = 0; j < layer.samples.rows(); ++j) {
    constant_.segment<3>(3 * (layer.first_mode + j)) += layer.samples(j, sample) * force_W;
  }
}

// Takes the layers' stiffness.
void AttachmentState::AddLayers() {
  std::size_t first = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    if (changed_[l] != 0) FillStiffness(l, first);
    first += ToSize(joint_->layers()[l].bed.size());
  }
  factored_damage_ = now_.damage;
  factored_closed_ = now_.closed;
  solver_.FactorLayers();
}

// Takes the constant forces of the layers.
void AttachmentState::AddConstants() {
  constant_.setZero();
  std::size_t first = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    for (int i = 0; i < layer.bed.size() && borne_.rows() > 0; ++i) {
      const auto sample = static_cast<Eigen::Index>(first) + i;
      const double d = now_.damage[ToSize(sample)];
      if (d == 0) continue;
      Vector3d lost = d * layer.bed.areas[i] * layer.bed.law.stiffness * borne_.row(sample);
      if (now_.closed[ToSize(sample)] != 0) {
        const Vector3d n = layer.bed.normals_W.row(i);
        lost -= n.dot(lost) * n;
      }
      AddConstant(layer, i, -lost);
    }
    first += ToSize(layer.bed.size());
  }
}

// Fills a layer's block of R. Samples respond alike along all axes, unless they are damaged and closed,
// which carry pressure alone, or those of a leaf.
void AttachmentState::FillStiffness(std::size_t l, std::size_t first_sample) {
  const AttachmentJoint::Layer& layer = joint_->layers()[l];
  const CohesiveLaw& law = layer.bed.law;
  const auto count = ToSize(layer.bed.size());
  const auto damage = std::span(now_.damage).subspan(first_sample, count);
  if (factored_damage_.empty() ||
      !std::ranges::equal(damage, std::span(factored_damage_).subspan(first_sample, count))) {
    const Eigen::Index s = layer.samples.rows();
    auto sum = solver_.RoomFor(l);
    for (int i = 0; i < layer.bed.size(); ++i) {
      const double alike = layer.bed.areas[i] * law.Alike(damage[ToSize(i)]);
      if (alike == 0) continue;
      const auto m = layer.samples.col(i);
      for (Eigen::Index c = 0; c < s; ++c) sum.col(c).tail(s - c) += alike * m[c] * m.tail(s - c);
    }
    solver_.TakeAlike(l);
  }
  solver_.ClearBeside(l);
  for (int i = 0; i < layer.bed.size(); ++i) {
    const bool closed = now_.closed[first_sample + ToSize(i)] != 0;
    const double beside = layer.bed.areas[i] * law.BesideAlike(damage[ToSize(i)], closed);
    if (beside == 0) continue;
    solver_.AddBeside(l, layer.samples.col(i),
                      std::sqrt(beside) * Vector3d(layer.bed.normals_W.row(i)));
  }
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
        changed_[l] = 1;
      }
      const char closed = law.Closed(delta, normal) ? 1 : 0;
      if (closed == now_.closed[at]) continue;
      now_.closed[at] = closed;
      if (!law.HasBeside(now_.damage[at], true) && !law.HasBeside(now_.damage[at], false)) continue;
      settled = false;
      changed_[l] = 1;
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
  std::ranges::fill(changed_, 1);
  ducts_changed_ = true;
}

void AttachmentState::Report(const Eigen::VectorXd& w,
                             std::span<AttachmentOutcome> outcomes) const {
  std::size_t at = 0;
  for (std::size_t l = 0; l < joint_->layers().size(); ++l) {
    const AttachmentJoint::Layer& layer = joint_->layers()[l];
    AttachmentOutcome& outcome = outcomes[l];
    outcome = {};
    for (int i = 0; i < layer.bed.size(); ++i, ++at) {
      const double area = layer.bed.areas[i], d = now_.damage[at];
      const Vector3d delta = DisplacementOf(layer, i, w) + BorneBy(at);
      outcome.load_W -= area * StiffnessOf(layer.bed, i, d, now_.closed[at] != 0) * delta;
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
