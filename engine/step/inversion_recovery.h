#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "engine/organ/organ_state.h"

namespace hpdm {

/// Keeps an organ of finite strain sound, and reports inversions of every organ with a lattice
/// (inversion_detector.h). A state is unsound if it is inverted, not finite, or running away. The
/// demand is how far the contacts' targets lie from rest, m.
///
/// Finite strain needs recovery: Newton's method starts from its last state, and an inverted state
/// can be an energy minimum with forces of another branch. St. Venant-Kirchhoff and the metric
/// energy do not resist inversion. A step that leaves the organ unsound is rejected:
///
/// 1. The organ returns to the last sound state. One Newton iteration takes it to nine tenths of
///    the demand there.
/// 2. It then follows its tools by load steps. They start at dt / 0.25 s of the demand, at least
///    1/8, and halve after each failure. The organ stays where the next step would fail.
/// 3. Recovery ends once the demand does not exceed the demand that has been followed.
/// 4. If even the last sound state fails, the organ is reset to rest.
///
/// Inversions are only reported:
///
/// - in small strain, which is linear: the inversion disappears with its demand. A scan of tissue
///   that cannot be cleared at once takes up to a second of steps;
/// - while adaptive strain blends both measures (blended_energy.h);
/// - in viscoelastic tissue after its release, which is a damped return already.
///
/// The tools are not held back: the haptic force grows with depth on the stiffness of the sound
/// state, and the guard bounds it (force_guard.h). All decisions follow from tools, step times and
/// iterations, so a replay makes the same. Deformation thread; allocates nothing.
class InversionRecovery {
 public:
  /// `model` must outlive it; `state` gives the sizes.
  InversionRecovery(const OrganModel& model, const OrganState& state);

  /// After a copy: as MaxwellMemory::Rebind().
  void Rebind(const Relaxation& relaxation) { at_rest_.Rebind(relaxation); }

  /// Begins stage B of a step `dt` (s) after the last one: sets the targets of the state's contacts
  /// that the organ follows.
  void Begin(double dt, OrganState* state);
  /// The input of the relaxation, after Begin() or Rejects(). Valid until End().
  const RelaxationInput& input() const { return input_; }
  /// True if the relaxation with `result` left the organ unsound. It must then be relaxed once more,
  /// with the new targets and input.
  bool Rejects(const RelaxationResult& result, OrganState* state);
  /// True after Begin() if Rejects() may be true.
  bool MayReject() const { return attempt_ == Attempt::kFirst; }
  /// Ends stage B; `result`: of the last relaxation. Sets the state's contacts back to their demand
  /// and its result, which is for the demand that was met.
  void End(const RelaxationResult& result, OrganState* state);

  /// Stops the next Relax after `iterations` (> 0): a replay's (RelaxationInput::stop_after).
  void StopNextAfter(int iterations) { stop_after_ = iterations; }

  /// True if tissue was inverted in the last step, at its end or in the rejected step.
  bool inverted() const { return inverted_; }
  /// True if the organ follows its tools only part of the way.
  bool recovering() const { return recovering_; }
  /// True if the last step's rejected state was not finite.
  bool not_finite() const { return not_finite_; }
  /// InversionDetector::LargestGradient of the last step; adaptive strain only.
  double gradient() const { return gradient_; }

  /// Resets unknown `row` to rest: it now stands for another function.
  void ResetRow(int row) { sound_.row(row).setZero(); }

 private:
  static constexpr int kStepsPerScan = 30;  // small strain
  // Limit of displacement over organ size before a runaway. Control points with little tissue move
  // by metres in a lift of millimetres.
  static constexpr double kMaxExcursion = 1e6;

  // The relaxations of one step.
  enum class Attempt : std::uint8_t { kOnly, kFirst, kSecond };

  void WatchGradient(const OrganState& state);
  double Demand(const ContactConstraints& contacts) const;
  void ReachFor(double reach, OrganState* state);
  void SetTargetsBack(OrganState* state) const;
  void Judge(OrganState* state);
  void EndSecond(OrganState* state);
  RelaxationInput TakeInput(const OrganState& state);
  bool IsLinear(const OrganState& state) const;
  bool IsInverted(const OrganState& state);
  bool Sound(double demand, const OrganState& state);
  void Reset();

  const OrganModel* model_;
  const LatticeOrgan* lattice_organ_;                 // nullptr for other models
  std::optional<InversionDetector::ScanState> scan_;  // lattice organs only
  MaxwellMemory at_rest_;
  double size_;                  // m: the lattice's box
  int stop_after_ = 0;           // iterations of the next Relax; 0: no limit
  bool starts_at_rest_ = false;  // the next Relax starts at rest

  bool inverted_ = false;
  bool not_finite_ = false;
  bool recovering_ = false;
  double gradient_ = 0;
  double reach_ = 0;        // m: part of the demand that is followed while recovering
  double stride_ = 0;       // m: increase of reach_ in the next step
  double sound_reach_ = 0;  // m: demand at the last sound state
  Points sound_;            // n x 3, m: displacements of the last sound state

  // The present step.
  Attempt attempt_ = Attempt::kOnly;
  double dt_ = 0;      // s
  double demand_ = 0;  // m
  RelaxationInput input_;
  RelaxationResult first_;                      // of an attempt that was rejected
  std::array<Vector3d, kMaxContacts> targets_;  // m: of the demand
};

}  // namespace hpdm
