#include "engine/tissue/lumen_leaks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hpdm {
namespace {

// Share of a free wall's compliance that a step counts on.
constexpr double kHeldWall = 0.25;
// Pa. Less does not flow: it is the rounding of the pressure.
constexpr double kNoPressure = 1e-3;
// s: a late step leaks no longer than this.
constexpr double kLongestLeak = 0.1;

}  // namespace

LumenLeaks::LumenLeaks(const FillingsAndLayers& surface, const Lattice& lattice,
                       const LatticeCompliance& compliance, Eigen::Index rows, bool may_leak)
    : lumens_(surface.lumens()), may_leak_(may_leak), outcomes_(lumens_.size()) {
  if (lumens_.empty()) return;
  displacements_.setZero(rows, 3);
  const Eigen::MatrixXd fillings = surface.FillingRows(lattice);
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    const Lumen& lumen = lumens_[l];
    const double scale = std::sqrt(lumen.bulk_modulus / lumen.volume);
    const auto row = fillings.row(static_cast<Eigen::Index>(l));
    Eigen::MatrixXd response = Eigen::MatrixXd::Zero(3 * rows, 1);
    response.col(0).head(row.size()) = scale * row.transpose();
    compliance.SolveLoads(response);
    const double held = row.dot(response.col(0).head(row.size())) / scale;
    compliances_.push_back(lumen.volume / (lumen.bulk_modulus * (1 - held)));
    shapes_.emplace_back(Eigen::Map<const Points>(response.data(), rows, 3));
    rest_.push_back(RelativeChange(lumen, surface.rest_vertices()));
    outcomes_[l].pressure = lumen.pressure;
  }
}

void LumenLeaks::Perforate(std::size_t lumen) {
  if (may_leak_) outcomes_[lumen].perforated = true;
}

bool LumenLeaks::IsActive() const {
  return std::ranges::any_of(outcomes_, [](const LumenOutcome& lumen) {
    return lumen.lost != 0 || (lumen.perforated && std::abs(lumen.pressure) > kNoPressure);
  });
}

void LumenLeaks::Advance(double now_s, double dt) {
  dt = std::clamp(dt, 0.0, kLongestLeak);
  bool moved = false;
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    LumenOutcome& outcome = outcomes_[l];
    if (lumens_[l].perforated_at && now_s >= *lumens_[l].perforated_at) Perforate(l);
    if (!outcome.perforated || !(std::abs(outcome.pressure) > kNoPressure)) continue;
    const double compliance = kHeldWall * compliances_[l];
    const double share = -std::expm1(-dt / (lumens_[l].leak_resistance * compliance));
    outcome.lost += compliance * share * outcome.pressure;
    moved = true;
  }
  if (!moved) return;
  lost_ = true;
  displacements_.setZero();
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    displacements_ -= outcomes_[l].lost * shapes_[l];
  }
}

// The walls' areas sum to zero, so the change of volume depends on the rotation alone.
void LumenLeaks::FindPressures(const Points& vertices, const Matrix3d& R_WF) {
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    const Lumen& lumen = lumens_[l];
    double change = -rest_[l];
    for (std::size_t i = 0; i < lumen.vertices.size(); ++i) {
      const Vector3d area_F = lumen.areas_W.row(static_cast<Eigen::Index>(i));
      change += (R_WF * area_F).dot(vertices.row(lumen.vertices[i])) / lumen.volume;
    }
    const double pressure =
        lumen.pressure - lumen.bulk_modulus * (change + outcomes_[l].lost / lumen.volume);
    outcomes_[l].pressure = std::isfinite(pressure) ? pressure : 0;
  }
}

int LumenLeaks::NearestTo(const Vector3d& p_W, const Points& vertices, double* distance) const {
  int nearest = -1;
  *distance = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < lumens_.size(); ++l) {
    for (const int v : lumens_[l].vertices) {
      const double to = (vertices.row(v).transpose() - p_W).norm();
      if (to >= *distance) continue;
      *distance = to;
      nearest = static_cast<int>(l);
    }
  }
  return nearest;
}

}  // namespace hpdm
