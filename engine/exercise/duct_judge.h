#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/duct/duct_outcome.h"
#include "engine/exercise/clip_finding.h"
#include "engine/exercise/exercise_options.h"
#include "engine/scene_limits.h"

namespace hpdm {

/// The clips and cuts of an exercise's ducts so far. A duct's places are arc lengths at rest from its
/// end a. An end is the organ's if the organ that is taken out holds it (ExerciseDuct::organ_end); the
/// other ends stay in the body.
///
/// A clip is good if
///   1. the plane of the jaws is at most `angle` (rad) off the duct's normal plane,
///   2. the jaws cover at least kLeastCoverage of the width of the lumen, flattened between them,
///   3. at least kLeastGap is between its edge and that of each other clip, and
///   4. at least kLeastToEnd is between its edge and each end that stays in the body.
///
/// A duct is cut well if `stay` clips that cover the lumen are left between the cut and each end that
/// stays in the body, and one between the cut and the organ's end. Three clips, of which two stay, are
/// common practice; the distances are the project's own. One thread; a call allocates only to keep a clip or a
/// cut.
class DuctJudge {
 public:
  static constexpr double kClipWidth = 0.001;  ///< m, along the duct.
  static constexpr double kLeastGap = 0.002;   ///< m.
  static constexpr double kLeastCoverage = 0.98;
  static constexpr double kLeastToEnd = 0.003;  ///< m.

  explicit DuctJudge(std::vector<ExerciseDuct> ducts, int stay = kClipsThatStay);

  /// True if a new clip is good beside the ones so far.
  bool IsGood(const DuctAction& clip, double angle) const;
  /// Returns the faults of a new clip and its measures. No faults exactly if IsGood.
  ClipFinding Examine(const DuctAction& clip, double angle) const;
  /// The same of a clip on a duct whose nearest clip's middle is `gap` m from its own, along the duct.
  static ClipFinding Examine(const DuctAction& clip, double gap, const ExerciseDuct& duct,
                             double angle);
  /// Keeps a clip or a cut. `good`: of a clip.
  void Keep(const DuctAction& action, bool good);

  int GoodClips(int duct) const;
  bool IsCutWell(int duct) const;
  /// True if so many clips between a cut and the duct's ends a and b are enough.
  static bool AreEnough(int at_a, int at_b, const ExerciseDuct& duct, int stay);

 private:
  struct Clip {
    double arc = 0;  // m
    bool covers = false, good = false;
  };
  struct Duct {
    ExerciseDuct options;
    std::vector<Clip> clips = {};
    std::vector<double> cuts = {};  // m
  };
  const Duct* Find(int duct) const;

  std::vector<Duct> ducts_;
  int stay_;
};

/// Says each fault with its figure: "oblique: 38° (at most 20°)". `keys`: of an oblique clip, the keys
/// that roll it. `duct`: the name of the clip's duct. Empty without a fault.
std::string FaultText(const ClipFinding& clip, const std::string& duct, bool keys);

}  // namespace hpdm
