#include "haptics/device/hand_script.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"
#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr double kHold = 0.6;                // s
constexpr double kJawTime = 0.3;             // s, to open or close
constexpr double kMinReachTime = 0.1;        // s
constexpr double kMaxSpread = 0.15;          // of the organ's size
constexpr double kMaxHover = 0.030;          // m
constexpr double kTapHeight = 0.006;         // m
constexpr double kLightPress = 0.003;        // m: jaws take only what touches them
constexpr double kApproach = 0.060;          // m, from the start to the first hover point
constexpr double kMinStartInsertion = 0.03;  // m, at the start

Matrix3d SiteFrame(const Vector3d& normal) {
  Matrix3d R;
  R.col(2) = normal.normalized();
  R.col(0) = R.col(2).unitOrthogonal();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

void Validate(const HandOptions& options, const HandSite& site) {
  const auto refuse = [](const char* what) {
    throw InputError(std::string("instrument.hand: ") + what);
  };
  if (!(std::isfinite(options.speed) && options.speed > 0)) {
    refuse("speed: not positive; give the mean speed of a reach in m/s");
  }
  if (!(std::isfinite(options.depth) && options.depth >= 0)) {
    refuse("depth: negative or not finite; give a depth in m");
  }
  if (!(std::isfinite(options.spread) && options.spread > 0)) {
    refuse("spread: not positive; give a length in m");
  }
  if (!site.p_target_W.allFinite()) refuse("target: not finite; give a point in m");
  if (!site.normal_W.allFinite() || !(site.normal_W.norm() > 0)) {
    refuse("target: the surface has no normal there; choose another point");
  }
  if (!(std::isfinite(site.organ_size) && site.organ_size > 0)) {
    refuse("target: the organ has no size; check its mesh and unit");
  }
}

}  // namespace

HandScriptPlan::HandScriptPlan(const HandOptions& options, const HandSite& site)
    : options_(options), site_(site), random_(options.seed) {
  Validate(options, site);
  R_WS_ = SiteFrame(site.normal_W);
  spread_ = std::min(options.spread, kMaxSpread * site.organ_size);
  hover_ = std::min(kMaxHover, 0.2 * site.organ_size);

  const Vector3d p_hover = At(0, 0, hover_);
  const Vector3d to_trocar = site.p_trocar_W - p_hover;
  const double back = std::clamp(to_trocar.norm() - kMinStartInsertion, 0.0, kApproach);
  start_.p_W = p_hover;
  if (back > 0) start_.p_W += back * to_trocar.normalized();
  last_ = start_;
}

WayPoint HandScriptPlan::Next() {
  if (next_ == planned_) {
    planned_ = next_ = 0;
    PlanCycle();
  }
  return cycle_[next_++];
}

void HandScriptPlan::PlanCycle() {
  switch (options_.script) {
    case HandScript::kPalpate:
      return PlanPalpate();
    case HandScript::kTap:
      return PlanTap();
    case HandScript::kSlide:
      return PlanSlide();
    case HandScript::kGraspLift:
      return PlanGrasp(R_WS_.col(2));
    case HandScript::kGraspPull:
      return PlanGrasp((site_.p_trocar_W - site_.p_target_W).normalized());
    case HandScript::kRandom:
      return PlanRandom();
  }
}

void HandScriptPlan::PlanPalpate() {
  const double angle = random_.Uniform(0, 2 * std::numbers::pi);
  const double offset = random_.Uniform(0.5, 1) * spread_;
  const double x = offset * std::cos(angle), y = offset * std::sin(angle);
  Add(At(x, y, hover_), 1);
  Add(At(x, y, -options_.depth), 1);
  Add(At(x, y, -options_.depth), 1, kHold);
  Add(At(x, y, hover_), 1);
}

void HandScriptPlan::PlanTap() {
  const double period = random_.Uniform(1.0 / 3, 1.0 / 2);
  const double height = std::min(kTapHeight, hover_);
  // The first reach comes down from the start at the hand's own speed.
  if (last_.p_W == start_.p_W) Add(At(0, 0, height), 1);
  Add(At(0, 0, -options_.depth), 1, 0.35 * period);
  Add(At(0, 0, height), 1, 0.35 * period);
  Add(At(0, 0, height), 1, 0.30 * period);
}

void HandScriptPlan::PlanSlide() {
  const double angle = random_.Uniform(0, 2 * std::numbers::pi);
  const double x = spread_ * std::cos(angle), y = spread_ * std::sin(angle);
  Add(At(0, 0, hover_), 1);
  Add(At(0, 0, -options_.depth), 1);
  for (int pass = 0; pass < 2; ++pass) {
    Add(At(x, y, -options_.depth), 1);
    Add(At(-x, -y, -options_.depth), 1);
  }
  Add(At(0, 0, -options_.depth), 1);
  Add(At(0, 0, hover_), 1);
}

void HandScriptPlan::PlanGrasp(const Vector3d& direction_W) {
  const Vector3d p_pressed = At(0, 0, -std::min(kLightPress, options_.depth));
  const Vector3d p_lifted = p_pressed + options_.depth * direction_W;
  Add(At(0, 0, hover_), 1);
  Add(p_pressed, 1);
  Add(p_pressed, 0, kJawTime);
  Add(p_lifted, 0);
  Add(p_lifted, 0, kHold);
  Add(p_pressed, 0);
  Add(p_pressed, 1, kJawTime);
  Add(At(0, 0, hover_), 1);
}

void HandScriptPlan::PlanRandom() {
  const double x = random_.Uniform(-1, 1) * spread_, y = random_.Uniform(-1, 1) * spread_;
  const double roll = random_.Uniform(-0.8, 0.8);
  const double jaw = random_.Uniform(0, 1) < 0.5 ? random_.Uniform(0, 1) : last_.jaw;
  const double depth = random_.Uniform(0.2, 1) * options_.depth;
  switch (static_cast<int>(random_.Uniform(0, 3))) {
    case 0:  // somewhere above the surface
      Add(At(x, y, random_.Uniform(0.2, 1) * hover_), jaw, 0, roll);
      break;
    case 1:  // a poke, with or without a hold
      Add(At(x, y, 0.5 * hover_), jaw, 0, roll);
      Add(At(x, y, -depth), jaw, random_.Uniform(0.12, 0.5), roll);
      Add(At(x, y, -depth), jaw, random_.Uniform(0.02, 0.4), roll);
      Add(At(x, y, 0.5 * hover_), jaw, random_.Uniform(0.12, 0.5), roll);
      break;
    default:  // into the surface and along it
      Add(At(x, y, -depth), jaw, 0, roll);
      Add(last_.p_W, random_.Uniform(0, 1), kJawTime, roll);
      break;
  }
}

void HandScriptPlan::Add(const Vector3d& p_W, double jaw, double seconds, double roll) {
  HPDM_CHECK(planned_ < kMaxCycle);
  if (seconds <= 0) {
    seconds = std::max(kMinReachTime, (p_W - last_.p_W).norm() / options_.speed);
  }
  last_.p_W = p_W;
  last_.roll = roll;
  last_.jaw = jaw;
  last_.duration_ns = static_cast<Nanoseconds>(std::ceil(std::max(seconds, 1e-3) * 1e9));
  cycle_[planned_++] = last_;
}

Vector3d HandScriptPlan::At(double along_x, double along_y, double height) const {
  return site_.p_target_W + R_WS_ * Vector3d(along_x, along_y, height);
}

}  // namespace hpdm
