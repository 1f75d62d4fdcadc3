#pragma once

#include <algorithm>
#include <vector>

#include "engine/base/types.h"
#include "engine/step/strain_blend_controller.h"

namespace hpdm {

/// What the organs of a scene have that a step could leave out.
struct Sheddable {
  int newton_iterations = 1;  ///< The most of any organ of finite or adaptive strain.
  bool finite = false;
  bool refinement = false;
};
Sheddable SheddableOf(const std::vector<OrganOptions>& organs);

/// Lowers what deformation steps do when they take longer than their budget, level by level and in
/// this order, so far as the organs have it: half as many Newton iterations, and half of those
/// until one is left; no finite strain; no local functions. Raises it again when there is time.
///
/// A level falls when kTooMany steps in a row were too long, since one may have been the host's
/// doing, and the organs have followed the last level down (StrainBlendController::settled). It
/// rises after steps at less than kEase of the budget for as long as it waits: kWait, and twice as
/// long each time that a level which rose fell again within as long as it had waited, up to
/// kMaxWait. So a load that lasts is tried out ever more rarely, and quality does not go to and
/// fro.
///
/// Only steps in which an organ is touched say anything of the load. One thread; allocates nothing.
class LoadShedding {
 public:
  static constexpr int kTooMany = 2;
  static constexpr double kEase = 0.6;
  static constexpr Nanoseconds kWait = kNanosecondsPerSecond;
  static constexpr Nanoseconds kMaxWait = 64 * kNanosecondsPerSecond;

  /// `budget`: of a step, ns; 0: nothing is shed.
  LoadShedding(const Sheddable& sheddable, Nanoseconds budget);

  /// A step begun at session time `now_ns` took `compute_ns`.
  void Observe(Nanoseconds now_ns, Nanoseconds compute_ns, bool settled);
  /// What a replay takes in its place.
  void ApplyRecorded(int level) { level_ = std::clamp(level, 0, levels()); }

  int level() const { return level_; }  ///< 0: nothing is shed.
  int levels() const { return halvings_ + (finite_ ? 1 : 0) + (refinement_ ? 1 : 0); }
  QualityCeiling Ceiling() const;

 private:
  void Lower(Nanoseconds now_ns);
  void Raise(Nanoseconds now_ns);

  Nanoseconds budget_;
  int halvings_ = 0;  // that the organs have in all
  bool finite_ = false;
  bool refinement_ = false;
  int level_ = 0;
  int too_long_ = 0;                // steps in a row
  Nanoseconds easy_since_ns_ = -1;  // -1: the last step was not
  Nanoseconds raised_ns_ = -1;      // -1: never
  Nanoseconds wait_ns_ = kWait;
};

}  // namespace hpdm
