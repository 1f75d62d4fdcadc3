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

}  // namespace

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
  const Matrix3d along_normal = normal_W * normal_W.transpose();
  factor_W_ = ((1 - nu * nu) * along_normal +
               (1 + nu) * (1 - nu / 2) * (Matrix3d::Identity() - along_normal)) /
              material.young;
}

Matrix3d LocalIndentation::Compliance() const {
  return MeanKernelSinking() * (1 / radius_ - 1 / resolved_radius_) * factor_W_;
}

}  // namespace hpdm
