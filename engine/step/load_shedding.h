#pragma once

#include <algorithm>
#include <vector>

#include "engine/base/types.h"
#include "engine/step/strain_blend_controller.h"

namespace hpdm {

/// Parts of a scene's organs that a step can leave out.
struct Sheddable {
  int newton_iterations = 1;  ///< Maximum over the organs of finite or adaptive strain.
  bool finite = false;
  bool refinement = false;
};
Sheddable SheddableOf(const std::vector<OrganOptions>& organs);

/// Lowers the quality of deformation steps that exceed their budget, and raises it again when there
/// is time. The levels, so far as the organs have them:
///
/// 1. Newton iterations are halved, one level per halving, until kLeastNewtonIterations or fewer are
///    left.
/// 2. Finite strain is switched off.
/// 3. Local functions are switched off.
///
/// Quality falls by a level after kTooMany long steps in a row, since a single one may be the
/// host's doing. The organs must first have followed the previous change
/// (StrainBlendController::settled).
///
/// Quality rises by a level when all steps of a waiting time take less than kEase of the budget.
/// The waiting time is kWait. It doubles, up to kMaxWait, each time that a raised level falls again
/// within the waiting time. A lasting load is thus retried ever more rarely, so quality does not
/// oscillate.
///
/// Only steps in which an organ is touched count. One thread; allocates nothing.
class LoadShedding {
 public:
  static constexpr int kTooMany = 2;
  static constexpr double kEase = 0.6;
  static constexpr Nanoseconds kWait = kNanosecondsPerSecond;
  static constexpr Nanoseconds kMaxWait = 64 * kNanosecondsPerSecond;

  /// `budget`: ns per step; 0: nothing is shed.
  LoadShedding(const Sheddable& sheddable, Nanoseconds budget);

  /// Takes the compute time of a step that began at session time `now_ns`.
  void Observe(Nanoseconds now_ns, Nanoseconds compute_ns, bool settled);
  /// Sets the recorded level; a replay calls it instead of Observe.
  void ApplyRecorded(int level) { level_ = std::clamp(level, 0, levels()); }

  int level() const { return level_; }  ///< 0: nothing is shed.
  int levels() const { return halvings_ + (finite_ ? 1 : 0) + (refinement_ ? 1 : 0); }
  QualityCeiling Ceiling() const;

 private:
  void Lower(Nanoseconds now_ns);
  void Raise(Nanoseconds now_ns);

  Nanoseconds budget_;
  int halvings_ = 0;  // possible in all
  bool finite_ = false;
  bool refinement_ = false;
  int level_ = 0;
  int too_long_ = 0;                // steps in a row
  Nanoseconds easy_since_ns_ = -1;  // -1: the last step was not
  Nanoseconds raised_ns_ = -1;      // -1: never
  Nanoseconds wait_ns_ = kWait;
};

}  // namespace hpdm
