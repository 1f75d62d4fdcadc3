#pragma once

#include "engine/organ.h"
#include "engine/organ_quality.h"

namespace hpdm {

/// What the time allows all organs (load_shedding.h).
struct QualityCeiling {
  int halvings = 0;  ///< Of Newton's iterations; one always remains.
  bool finite = true;
  bool local = true;
};

/// Chooses one organ's quality step by step: what its state needs, under a ceiling, in steps that
/// no hand feels.
///
/// Adaptive strain takes small strain while |grad u| (FoldWatch::Sweep::gradient) is below
/// `finite_from` and finite strain alone from kWhole times that on; between them the share of
/// finite strain rises smoothly, so that the force is a function of where the tool is. On the way
/// back it stays as it is until |grad u| has fallen by kSlack.
///
/// However fast the tool moves, or when a ceiling falls, the share moves only so far in a step that
/// the force changes by about kForceStep of itself: of an energy E in which the contacts do no work
/// as s changes, E changes by (dE/ds) / E ds, and the force, E's derivative by the depth, by
/// kForceOverEnergy times as much (measured: 1.5 to 2, as of a difference of third and fourth order
/// in the depth). Without contact there is no force, and nothing to be gradual about.
///
/// Follows from the states alone; one thread; allocates nothing.
class QualityChoice {
 public:
  static constexpr double kWhole = 2;
  static constexpr double kSlack = 0.1;
  static constexpr double kForceStep = 0.005;
  static constexpr double kForceOverEnergy = 2;
  static constexpr double kFirstStep = 1.0 / 256;   ///< From small strain, where dE/ds is unknown.
  static constexpr double kLargestStep = 1.0 / 8;
  static constexpr double kLocalStep = 1.0 / 32;

  explicit QualityChoice(const OrganModel& model);

  /// For the next step. `state`: after the last one, in which the organ was `touched` or not;
  /// `gradient`: |grad u| there.
  OrganQuality Next(const QualityCeiling& ceiling, bool touched, double gradient,
                    double share_slope);
  /// What a replay takes in its place.
  void Obey(const OrganQuality& quality) { last_ = quality; }

  /// Whether the last Next() is where the ceiling and the state want it.
  bool settled() const { return settled_; }

 private:
  double NeededShare(double gradient) const;

  bool has_finite_;
  bool has_local_;
  bool adaptive_;
  double finite_from_;
  int iterations_;
  OrganQuality last_;
  bool settled_ = true;
};

}  // namespace hpdm
