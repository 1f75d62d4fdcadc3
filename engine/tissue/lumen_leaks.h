#pragma once

#include <span>
#include <vector>

#include "engine/contact/lattice_compliance.h"
#include "engine/tissue/fillings_and_layers.h"
#include "engine/tissue/lumen_outcome.h"

namespace hpdm {

/// The filled lumens of one organ in the course of a session. A perforated one leaks: fluid leaves
/// it, or gas enters, and what its pressure at rest held open goes slack.
///
/// 1. The fluid's pressure over that of the surroundings is, with the lost volume L,
///        p = p_0 - k (areas . u + L) / V,
///    with p_0 at rest (LumenOptions::pressure). So a loss moves the organ by -L S, S = K^-1 areas k / V,
///    and lowers the pressure by L / C, C = V / (k (1 - areas . S)), where nothing else holds it.
/// 2. A perforated lumen leaks by dL/dt = p / R, R its leak_resistance. Alone at p_0 it has
///        p = p_0 exp(-t / (R C)),   L = C (p_0 - p).
/// 3. A step takes the pressure of the last one's end, and less than the p C / 4 that a wall that is
///    held from all sides could lose: so it never swings. Alone a time constant of at least a second
///    is then right to 2 %.
///
/// Local functions do not follow the loss. Copies continue to the last bit. Deformation thread;
/// allocates nothing after its construction.
class LumenLeaks {
 public:
  /// An organ without fluid.
  LumenLeaks() = default;
  /// `surface`, `lattice`: of the organ; `compliance`: at rest, with the fillings; `rows`: control
  /// points and slots; `may_leak`: false if its lumens stay closed.
  LumenLeaks(const FillingsAndLayers& surface, const Lattice& lattice,
             const LatticeCompliance& compliance, Eigen::Index rows, bool may_leak);

  std::size_t size() const { return lumens_.size(); }
  std::span<const LumenOutcome> outcomes() const { return outcomes_; }
  /// Opens a lumen for good; nothing if it may not leak.
  void Perforate(std::size_t lumen);
  /// True while a step can change a loss or its shape.
  bool IsActive() const;
  /// Takes the fluid out for the next step at time `now_s`, `dt` (s) after the last one. Opens what
  /// the scene perforates then.
  void Advance(double now_s, double dt);
  /// Finds the pressures of a shape. `vertices`: V x 3, m; `R_WF`: the frame of a free organ.
  void FindPressures(const Points& vertices, const Matrix3d& R_WF);
  /// The displacements by the lost volumes without forces, rows x 3, m, in the organ's frame; nullptr
  /// while nothing has left.
  const Points* displacements() const { return lost_ ? &displacements_ : nullptr; }
  /// Returns C of a lumen, m^3/Pa.
  double ComplianceOf(std::size_t lumen) const { return compliances_[lumen]; }
  /// Returns the number of the lumen whose wall is nearest to a point of the organ as it is, and sets
  /// the distance (m); -1 without lumens. O(vertices of the walls).
  int NearestTo(const Vector3d& p_W, const Points& vertices, double* distance) const;

 private:
  std::vector<Lumen> lumens_;
  bool may_leak_ = false;
  std::vector<Points> shapes_;       // of each lumen, rows x 3, 1/m^2: S
  std::vector<double> compliances_;  // of each lumen, m^3/Pa
  std::vector<double> rest_;         // of each lumen: areas . rest vertices over V
  std::vector<LumenOutcome> outcomes_;
  Points displacements_;
  bool lost_ = false;
};

}  // namespace hpdm
