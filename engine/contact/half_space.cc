#include "engine/contact/half_space.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"

namespace hpdm {
namespace {

using std::numbers::pi;

// int k dA and int k r^2 dA of the kernel k(r) = cos(pi r / 2) over the unit disc.
constexpr double kIntegral = 4 - 8 / pi;
constexpr double kSecondMoment =
    2 * pi * (2 / pi - 6 * 8 / (pi * pi * pi) + 6 * 16 / (pi * pi * pi * pi));

// Returns (1 / pi) int k(y) / |x - y| dA_y / int k dA at |x| = s. In polar coordinates (rho, phi)
// about x the singularity cancels, and the integrand is smooth along every chord of the disc.
double IntegrateSinking(double s) {
  constexpr int kChords = 96, kSteps = 48;
  const double half_angle = s > 1 ? std::asin(1 / s) : pi;
  double sum = 0;
  for (int i = 0; i < kChords; ++i) {
    // phi runs from straight inwards to the last chord; both halves are equal.
    const double phi = (i + 0.5) / kChords * half_angle;
    const double inwards = s * std::cos(phi);
    const double root = std::sqrt(std::max(0.0, inwards * inwards - (s * s - 1)));
    const double begin = std::max(0.0, inwards - root), length = inwards + root - begin;
    for (int j = 0; j < kSteps; ++j) {
      const double rho = begin + (j + 0.5) / kSteps * length;
      const double r = std::sqrt(std::max(0.0, s * s + rho * rho - 2 * rho * inwards));
      sum += std::cos(pi * std::min(r, 1.0) / 2) * length / kSteps * 2 * half_angle / kChords;
    }
  }
  return sum / (kIntegral * pi);
}

class SinkingTable {
 public:
  SinkingTable() {
    for (int i = 0; i <= kIntervals; ++i) values_[i] = IntegrateSinking(i * kEnd / kIntervals);
    double sum = 0;
    for (int i = 0; i < kIntervals; ++i) {
      const double r = (i + 0.5) / kIntervals;
      sum += 2 * pi * r * std::cos(pi * r / 2) * At(r) / kIntervals;
    }
    mean_ = sum / kIntegral;
  }

  double At(double s) const {
    if (s >= kEnd) {
      // Two terms of the multipole series; the third is below 1e-3 of the first here.
      return (1 + kSecondMoment / kIntegral / (4 * s * s)) / (pi * s);
    }
    const double at = std::max(s, 0.0) * kIntervals / kEnd;
    const int i = std::min(static_cast<int>(at), kIntervals - 1);
    return values_[i] + (at - i) * (values_[i + 1] - values_[i]);
  }

  double mean() const { return mean_; }

 private:
  static constexpr int kIntervals = 128;
  static constexpr double kEnd = 3;
  std::array<double, kIntervals + 1> values_;
  double mean_ = 0;
};

const SinkingTable& Table() {
  static const SinkingTable table;
  return table;
}

// Sneddon's ball in units of R and E*, at the contact radius b.
struct BallContact {
  double force = 0;     // over E* R^2
  double approach = 0;  // over R
  double rate = 0;      // d approach / d b; d force / d b is 2 b times as large
};

BallContact BallAt(double b) {
  const double half_log = std::atanh(b);
  return {(b * b + 1) * half_log - b, b * half_log, half_log + b / (1 - b * b)};
}

// The approach is proportional to the force below `first`, and grows as under the kernel above
// `last`.
struct BallRange {
  double b_first = 0.01;
  double b_last = 1 / (2 * MeanKernelSinking());
  BallContact first = BallAt(b_first);
  BallContact last = BallAt(b_last);
};

const BallRange& Range() {
  static const BallRange range;
  return range;
}

// Returns the contact radius for a force within the range by Newton's method, from the first two
// terms of the force's series, 4/3 b^3 + 8/15 b^5.
double BallRadius(double force) {
  constexpr int kMaxSteps = 12;
  const double hertz = std::cbrt(0.75 * force);
  double b = hertz / std::cbrt(1 + 0.4 * hertz * hertz);
  for (int i = 0; i < kMaxSteps; ++i) {
    const BallContact at = BallAt(b);
    const double change = (at.force - force) / (2 * b * at.rate);
    b -= change;
    if (std::abs(change) <= 1e-8 * b) break;  // the next change is about its square
  }
  return b;
}

// Solves  k force(b) + approach(b) = depth  within the range, k > -1 / (2 b_last). The left side
// increases, so Newton's method stays between known bounds or bisects.
double BallRadiusAtDepth(double depth, double k) {
  constexpr int kMaxSteps = 40;
  double low = Range().b_first, high = Range().b_last;
  double b = std::clamp(std::sqrt(depth), low, high);  // Hertz without k
  if (k > 0) b = std::clamp(std::cbrt(0.75 * depth / k), low, b);
  for (int i = 0; i < kMaxSteps; ++i) {
    const BallContact at = BallAt(b);
    const double off = k * at.force + at.approach - depth;
    (off > 0 ? high : low) = b;
    const double next = b - off / (at.rate * (2 * b * k + 1));
    const double last = b;
    b = next >= low && next <= high ? next : (low + high) / 2;
    if (std::abs(b - last) <= 1e-13 * b) break;
  }
  return b;
}

// Second moment of the kernel over its integral, for R = 1.
constexpr double kVariance = kSecondMoment / kIntegral;

// Mean sinking of a kernel under another one at the distance s R, and the mean of that over the
// disc of radius s, times s^2 / 2.
class PairTable {
 public:
  PairTable() {
    for (int i = 0; i <= kIntervals; ++i) mean_[i] = Mean(i * kStep);
    disc_[0] = 0;
    for (int i = 0; i < kIntervals; ++i) {  // int t (a + b (t - t_i)) dt over an interval
      const double t = i * kStep;
      const double slope = (mean_[i + 1] - mean_[i]) / kStep;
      disc_[i + 1] = disc_[i] + mean_[i] * (t + kStep / 2) * kStep +
                     slope * (t * kStep * kStep / 2 + kStep * kStep * kStep / 3);
    }
  }

  // {mean, radial} in 1/R.
  std::array<double, 2> At(double s) const {
    if (s >= kEnd) {
      const double far = kVariance / (2 * s * s);
      return {(1 + far) / (pi * s), (1 - far) / (pi * s)};
    }
    const double at = s / kStep;
    const int i = std::min(static_cast<int>(at), kIntervals - 1);
    const double mean = mean_[i] + (at - i) * (mean_[i + 1] - mean_[i]);
    if (i == 0) return {mean, mean / 2};
    const double disc = disc_[i] + (at - i) * (disc_[i + 1] - disc_[i]);
    return {mean, disc / (s * s)};
  }

 private:
  static constexpr int kIntervals = 128;
  static constexpr double kEnd = 4;
  static constexpr double kStep = kEnd / kIntervals;

  static double Mean(double s) {
    constexpr int kRings = 32, kAngles = 32;
    double sum = 0, weight = 0;
    for (int i = 0; i < kRings; ++i) {
      const double r = (i + 0.5) / kRings;
      const double k = r * std::cos(pi * r / 2);
      for (int j = 0; j < kAngles; ++j) {
        const double angle = (j + 0.5) / kAngles * pi;
        sum += k * Table().At(std::sqrt(s * s + r * r + 2 * s * r * std::cos(angle)));
        weight += k;
      }
    }
    return sum / weight;
  }

  std::array<double, kIntervals + 1> mean_;
  std::array<double, kIntervals + 1> disc_;
};

const PairTable& Pairs() {
  static const PairTable table;
  return table;
}

// Returns the mean of 1/r over all pairs of points of a rectangle, 1/m.
double MeanInverseDistance(const Eigen::Vector2d& sides) {
  const double a = sides[0], b = sides[1], diagonal = sides.norm();
  const double sum = a * a * b * std::asinh(b / a) + a * b * b * std::asinh(a / b) +
                     (a * a * a + b * b * b - diagonal * diagonal * diagonal) / 3;
  return 2 * sum / (a * a * b * b);
}

}  // namespace

PairSinking KernelPairSinking(double d, double radius) {
  const auto [mean, radial] = Pairs().At(d / radius);
  PairSinking sinking{mean / radius, radial / radius, 0};
  // The share of one load within the distance d of the other, as if both were Gaussian.
  const double within = -std::expm1(-d * d / (2 * kVariance * radius * radius));
  if (d > 0) sinking.inward = within / (2 * pi * d);
  return sinking;
}

PairSinking UniformPairSinking(double d, const Eigen::Vector2d& sides,
                               const Eigen::Vector2d& other_sides) {
  if (!(d > 0)) {
    const double mean = MeanInverseDistance(sides) / pi;
    return {mean, mean / 2, 0};
  }
  const double further = (sides.squaredNorm() + other_sides.squaredNorm()) / (48 * d * d);
  return {(1 + further) / (pi * d), (1 - further) / (pi * d), 1 / (2 * pi * d)};
}

Matrix3d SurfaceGreen(const MaterialOptions& material, const Vector3d& normal_W,
                      const Vector3d& offset_W, const PairSinking& sinking) {
  const double nu = material.poisson;
  const Matrix3d along_normal = normal_W * normal_W.transpose();
  const Matrix3d tangential = Matrix3d::Identity() - along_normal;
  const Vector3d e_W = (tangential * offset_W).stableNormalized();
  const Matrix3d radial = e_W * e_W.transpose();
  const double across = sinking.mean - sinking.radial;
  Matrix3d C = (1 - nu) * sinking.mean * (along_normal + tangential);
  if (e_W.squaredNorm() > 0) {
    C += nu * (sinking.radial * radial + across * (tangential - radial));
    C += (1 - 2 * nu) * sinking.inward * (e_W * normal_W.transpose() - normal_W * e_W.transpose());
  } else {
    C += nu * sinking.mean / 2 * tangential;
  }
  return (1 + nu) / material.young * C;
}

double KernelSinking(double d_over_R) { return Table().At(d_over_R); }

double MeanKernelSinking() { return Table().mean(); }

double IndentationProfile(double d, double radius, double resolved_radius) {
  if (d >= IndentationReach(radius, resolved_radius)) return 0;
  return KernelSinking(d / radius) / radius - KernelSinking(d / resolved_radius) / resolved_radius;
}

LocalIndentation::LocalIndentation(const MaterialOptions& material, const Vector3d& normal_W,
                                   double radius, double resolved_radius)
    : normal_W_(normal_W), radius_(radius), resolved_radius_(resolved_radius) {
  HPDM_CHECK(radius > 0 && resolved_radius >= radius);
  const double nu = material.poisson;
  E_star_ = material.young / (1 - nu * nu);
  const Matrix3d along_normal = normal_W * normal_W.transpose();
  factor_W_ = ((1 - nu * nu) * along_normal +
               (1 + nu) * (1 - nu / 2) * (Matrix3d::Identity() - along_normal)) /
              material.young;
}

Matrix3d LocalIndentation::Compliance() const {
  return MeanKernelSinking() * (1 / radius_ - 1 / resolved_radius_) * factor_W_;
}

double LocalIndentation::Yield(double f_n) const {
  const auto& [b_first, b_last, first, last] = Range();
  const double force = f_n / (E_star_ * radius_ * radius_), mean = MeanKernelSinking();
  double yield = first.approach / first.force;
  if (force > last.force) {
    yield = (last.approach + mean * (force - last.force)) / force;
  } else if (force > first.force) {
    yield = BallAt(BallRadius(force)).approach / force;
  }
  return yield / radius_ - mean / resolved_radius_;
}

double LocalIndentation::YieldRate(double f_n) const {
  const auto& [b_first, b_last, first, last] = Range();
  const double force = f_n / (E_star_ * radius_ * radius_), mean = MeanKernelSinking();
  double rate = first.approach / first.force;
  if (force > last.force) {
    rate = mean;
  } else if (force > first.force) {
    rate = 1 / (2 * BallRadius(force));
  }
  return rate / radius_ - mean / resolved_radius_;
}

double LocalIndentation::BallYield(double f_n) const {
  if (!indents()) return 0;
  if (stiffening_ == 1 && dent_force_ == 0) return Yield(f_n);
  const double further = f_n / stiffening_, force = dent_force_ + further;
  // The difference below would be round-off.
  if (further <= 1e-6 * dent_force_) return YieldRate(dent_force_) / stiffening_;
  if (dent_force_ == 0) return Yield(force) / stiffening_;
  return (force * Yield(force) - dent_force_ * Yield(dent_force_)) / f_n;
}

double LocalIndentation::BallYieldRate(double f_n) const {
  if (!indents()) return 0;
  return YieldRate(dent_force_ + f_n / stiffening_) / stiffening_;
}

LocalIndentation LocalIndentation::WithMemory(double stiffening, double dent_force) const {
  LocalIndentation indentation = *this;
  indentation.stiffening_ = stiffening;
  indentation.dent_force_ = dent_force;
  return indentation;
}

LocalIndentation LocalIndentation::UnderBall(double f_n) const {
  LocalIndentation indentation = WithMemory(1, 0);
  if (!indents()) return indentation;
  const double mean = MeanKernelSinking();
  indentation.radius_ = mean / (BallYield(f_n) + mean / resolved_radius_);
  return indentation;
}

double LocalIndentation::PressingForce(double depth, double compliance, double along) const {
  if (!indents() || !(along > 0)) return depth / compliance;
  if (stiffening_ == 1 && dent_force_ == 0) return Balance(depth, compliance, along);
  const double of_equilibrium = stiffening_ * compliance;
  const double dent = dent_force_ > 0 ? dent_force_ * Yield(dent_force_) : 0;
  const double force =
      Balance(depth + of_equilibrium * dent_force_ + along * dent, of_equilibrium, along);
  return std::max(0.0, stiffening_ * (force - dent_force_));
}

// PressingForce without memory.
double LocalIndentation::Balance(double depth, double compliance, double along) const {
  const auto& [b_first, b_last, first, last] = Range();
  const double mean = MeanKernelSinking();
  // In units of R and E*, with the share of the resolved kernel in k.
  const double k = (compliance / along - mean / resolved_radius_) * radius_;
  const double scaled = depth / (along * E_star_ * radius_);
  const double first_depth = k * first.force + first.approach;
  const double last_depth = k * last.force + last.approach;
  double force = 0;
  if (scaled <= first_depth) {
    force = scaled / first_depth * first.force;
  } else if (scaled >= last_depth) {
    force = last.force + (scaled - last_depth) / (k + mean);
  } else {
    force = BallAt(BallRadiusAtDepth(scaled, k)).force;
  }
  return force * E_star_ * radius_ * radius_;
}

}  // namespace hpdm
