#pragma once

#include <optional>

#include "engine/organ.h"

namespace hpdm {

/// Keeps an organ of finite strain sound, and tells of every other organ with a lattice whether it
/// is inverted (inversion_detector.h).
///
/// Small strain is linear: an inversion is gone with the demand that made it and says only that
/// picture and force are beyond what the model means, so it is told and nothing is changed; the
/// detector takes up to a second of steps for a scan of what it cannot clear at once.
///
/// Newton's method goes on from where it ended, and an inversion there may be a minimum of its own
/// (St. Venant-Kirchhoff and the metric energy do not resist being turned inside out), with forces
/// of another branch. So when a step leaves an organ of finite strain unsound - inverted, not
/// finite, or running away - the step is rejected: from the last sound state, by one Newton
/// iteration, to nine tenths of the way from rest that the contacts had gone there. From then on
/// the organ follows its tools by load steps, an eighth of the way or what belongs to the step of
/// 0.25 s for all of it, each half as long after one that fails, and stays where the next would
/// fail. It takes part in the whole way again as soon as that is not longer than what it has
/// followed. Where even the last sound state fails, the organ goes to rest and starts anew. What
/// viscous tissue does after its release is a damped return already and only told.
///
/// The tools are not held back: the tick's forces grow with their depth on the stiffness of the
/// sound state, and the guard bounds them (force_guard.h).
///
/// While an organ of adaptive strain blends both (blended_energy.h) an inversion is told only, as
/// in small strain.
///
/// All decisions follow from tools, step times and iterations, so a replay makes the same.
/// Deformation thread; allocates nothing.
class InversionRecovery {
 public:
  /// `model` must outlive it; `state` tells the sizes.
  InversionRecovery(const OrganModel& model, const OrganState& state);

  /// Stage B of a step `dt` (s) after the last one: relaxes the state's control displacements under
  /// its contacts, through its recovery. The result tells of the demand that was met in the end.
  RelaxationResult Relax(double dt, OrganState* state);

  /// Of the last step: tissue was inverted, in the end or by the rejected step.
  bool inverted() const { return inverted_; }
  /// The organ follows its tools part of the way.
  bool recovering() const { return recovering_; }
  /// Of the last step: the rejected step was not finite.
  bool not_finite() const { return not_finite_; }
  /// InversionDetector::LargestGradient of the last step; adaptive strain only.
  double gradient() const { return gradient_; }

  /// Unknown `row` means something else from now on: it starts at rest.
  void ResetRow(int row) { sound_.row(row).setZero(); }

 private:
  static constexpr int kStepsPerScan = 30;  // of small strain
  // Control points with little tissue move by metres in a lift of millimetres: this is a runaway.
  static constexpr double kMaxExcursion = 1e6;

  RelaxationResult RelaxSoundly(double dt, OrganState* state);
  void WatchGradient(const OrganState& state);
  double Demand(const ContactConstraints& contacts) const;
  RelaxationResult RelaxWithin(double reach, double dt, OrganState* state);
  bool IsLinear(const OrganState& state) const;
  bool IsInverted(const OrganState& state);
  bool Sound(double demand, const OrganState& state);
  RelaxationResult RejectStep(double demand, double dt, OrganState* state);
  void Reset();

  const OrganModel& model_;
  std::optional<InversionDetector::ScanState> scan_;  // of a lattice's tissue
  const ViscousRecovery at_rest_;
  double size_;  // m, of the lattice's box

  bool inverted_ = false;
  bool not_finite_ = false;
  bool recovering_ = false;
  double gradient_ = 0;
  double reach_ = 0;          // m: of the demand that is followed while recovering
  double stride_ = 0;         // m: by which the next step reaches farther
  double sound_reach_ = 0;    // m: demand at the last sound state
  Points sound_;              // n x 3, m: its displacements
  ViscousRecovery recovery_;  // as the last step left it
};

}  // namespace hpdm
