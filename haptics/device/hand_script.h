#pragma once

#include <array>
#include <cstdint>
#include <random>

#include "engine/base/types.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Workplace of a simulated hand.
struct HandSite {
  Vector3d p_target_W = Vector3d::Zero();  ///< Point on the organ's rest surface, m.
  Vector3d normal_W = Vector3d::UnitZ();   ///< Outward at the target, any length.
  Vector3d p_trocar_W = Vector3d::Zero();  ///< m.
  double organ_size = 0.2;                 ///< m, characteristic size: bounds the scripts' range.
};

/// Random numbers that are the same with every standard library. The standard specifies the output
/// of std::mt19937 but not of its distributions, so this class maps to doubles itself.
class HandRandom {
 public:
  explicit HandRandom(std::uint32_t seed) : engine_(seed) {}
  /// Returns one of 2^32 equally likely values in [low, high).
  double Uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) * 0x1p-32);
  }

 private:
  std::mt19937 engine_;
};

/// Intended state after `duration_ns`, reached from the previous way point by a minimum-jerk
/// movement. The same place as before is a hold.
struct WayPoint {
  Vector3d p_W = Vector3d::Zero();  ///< m.
  double roll = 0;                  ///< rad.
  double jaw = 1;                   ///< 0 closed .. 1 open.
  Nanoseconds duration_ns = 0;      ///< At least a millisecond.
};

/// The endless way points of one script of HandOptions around a site:
///
///   palpate     hover above a point, press to `depth`, hold 0.6 s, release, move to the next of
///               seeded points 10-20 mm around the target
///   tap         quick taps to `depth` on one point, 2-3 a second (seeded, tap by tap)
///   slide       press to `depth`, move forth and back along the surface in a seeded direction,
///               release
///   grasp_lift  reach with an open jaw, press lightly, close, lift by `depth` along the normal,
///               hold 0.6 s, put back, open
///   grasp_pull  the same, pulling towards the trocar instead
///   random      seeded way points around the target, pokes up to `depth`, jaw and roll moves
///
/// Reaches take distance / `speed`. The jaw stays open in palpate, tap and slide, so a grasper
/// never takes hold there. Distances along the surface reach `spread`, but at most 0.15 of the organ's
/// size. With `spread` = 20 mm every way point lies within 45 mm + `depth` of the target; the start is
/// up to 60 mm farther out. No allocation after construction.
class HandScriptPlan {
 public:
  /// Throws InputError if the options or the site make no movement possible.
  HandScriptPlan(const HandOptions& options, const HandSite& site);

  /// Starting point, between the trocar and the first hover point. duration_ns is 0.
  WayPoint Start() const { return start_; }

  /// Returns the next way point; there is always one.
  WayPoint Next();

 private:
  static constexpr int kMaxCycle = 12;

  void PlanCycle();
  void PlanPalpate();
  void PlanTap();
  void PlanSlide();
  void PlanGrasp(const Vector3d& direction_W);
  void PlanRandom();
  // Adds a way point; `seconds` <= 0: distance / speed.
  void Add(const Vector3d& p_W, double jaw, double seconds = 0, double roll = 0);
  // Returns the point at tangential offsets (m) and a height above the surface (m).
  Vector3d At(double along_x, double along_y, double height) const;

  HandOptions options_;
  HandSite site_;
  Matrix3d R_WS_;      // site frame: z the outward normal
  double spread_ = 0;  // m, largest tangential offset
  double hover_ = 0;   // m, height of the hover points
  HandRandom random_;
  WayPoint start_;
  WayPoint last_;  // last planned
  std::array<WayPoint, kMaxCycle> cycle_;
  int planned_ = 0;
  int next_ = 0;
};

}  // namespace hpdm
