#pragma once

#include <array>
#include <memory>

#include "engine/contact/indentation_memory.h"
#include "engine/energy/maxwell_law.h"
#include "engine/snapshots.h"
#include "engine/solver/elastic_supports.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// The memory of a viscoelastic organ (maxwell_law.h): the branches of every control point and local
/// function, and those of the dents under the tips.
///
/// 1. A branch k has the stiffness r_k K_t with K_t that of the organ at rest without its elastic
///    supports (elastic_supports.h). So with the displacements U and the branches W_k a step ends
///    with
///        dE/dU + K_t sum_k r_k W_k' = B^T f.
///    It is exact for a U that changes linearly during the step, whatever its length.
/// 2. A quadratic energy solves it by RelaxationInput::free and yield, another one by the damper.
///    Released tissue returns by the same law; with finite strain it returns linearly.
/// 3. Dents and footprints follow the same law: a tip's by IndentationMemory, a grasp row's by its
///    own displacement. Contacts of the shaft have elastic ones.
/// 4. A return ends when less than kStill remains.
///
/// Deformation thread; allocates nothing.
class MaxwellMemory {
 public:
  /// `n`: rows of U; `supports`: elastic ones, or nullptr.
  MaxwellMemory(const PronySeries& prony, int n,
                std::shared_ptr<ElasticSupports> supports = nullptr);

  /// After a copy: gives it elastic supports of its own, of the copy of its relaxation.
  void Rebind(const Relaxation& relaxation) {
    if (supports_ == nullptr) return;
    supports_ = std::make_shared<ElasticSupports>(supports_->CopyFor(*relaxation.compliance()));
  }

  bool IsElastic() const { return prony_.count == 0; }
  const PronySeries& prony() const { return prony_; }

  /// Begins a step `dt` (s) after the last one; at least 0.1 ms counts. Sets the damper of `input`
  /// and gives the rows of `contacts` the local law of the step.
  void Begin(double dt, ContactConstraints* contacts, RelaxationInput* input);
  /// Takes Begin() back, to begin the step again.
  void Cancel(ContactConstraints* contacts) const;
  /// Ends it with the displacements `U` (n x 3, m), which it may set to rest, and the rows' forces.
  /// Gives the rows their local law after relaxation back.
  void End(ContactConstraints* contacts, Points* U);
  /// Does Relaxation::Relax() of `relaxation` between the two.
  RelaxationResult Relax(double dt, Relaxation* relaxation, ContactConstraints* contacts, Points* U,
                         RelaxationInput input = {}) {
    Begin(dt, contacts, &input);
    const RelaxationResult result = relaxation->Relax(contacts, U, input);
    End(contacts, U);
    return result;
  }

  /// True if nothing is remembered.
  bool AtRest() const;

  /// Multiplies the state of row `row` by `share` (0..1). 0 starts a row with a new meaning at
  /// rest.
  void ScaleRow(int row, double share);

  /// The local part of one contact after the last step.
  struct LocalPart {
    Vector3d displacement_W = Vector3d::Zero();       ///< m.
    BranchStrains branches_W = NoBranchStrains();     ///< Grasp row, m.
    Vector3d equilibrium_force_W = Vector3d::Zero();  ///< Press: after relaxation, N.
  };
  const LocalPart& local(int row) const { return local_[static_cast<std::size_t>(row)]; }

  /// Returns the branches of a point with row b: b P W_k, m, with P = K^-1 K_t.
  BranchStrains BranchesAt(const SparseRow& b) const;
  /// Returns sum_k r_k w_k: how far the point's force exceeds that after relaxation, as a
  /// displacement, m.
  Vector3d Excess(const BranchStrains& branches_W) const;
  /// The part of a point's compliance that does not relax (ElasticSupports::InSeries), m/N.
  /// `response`: K^-1 b^T.
  Matrix3d InSeries(const Eigen::Ref<const Eigen::MatrixXd>& response) const {
    return supports_ ? supports_->InSeries(response, prony_.InstantaneousFactor() - 1)
                     : Matrix3d::Zero();
  }
  Matrix3d InSeries(const SparseRow& b) const {
    return supports_ ? supports_->InSeries(b, prony_.InstantaneousFactor() - 1) : Matrix3d::Zero();
  }

  /// A dent that a tip has left, or still presses.
  struct Dent {
    bool used = false;
    bool pressed = false;  ///< In the last step.
    LocalIndentation indentation;
    Vector3d p_rest_W = Vector3d::Zero();
    IndentationMemory memory;
  };
  /// The dents of the tools' tips, those of their first places first.
  const std::array<Dent, kMaxInstruments * kMaxPlaces>& dents() const { return dents_; }

 private:
  // The footprint of one tool's jaws.
  struct Held {
    int rows = 0;
    std::array<MaxwellState<Vector3d>, kGraspRows> states;
    const LocalCoupling* coupling = nullptr;  // after relaxation
    LocalCoupling stiffer;                    // the same in the present step, m/N
  };

  // Kinds of rows that have a local memory.
  enum class Part { kNone, kDent, kFootprint };
  static Part PartOf(const ContactConstraints::Row& row);
  void BeginDent(ContactConstraints::Row* row);
  void BeginFootprint(ContactConstraints::Row* row, int place);
  Dent& DentOf(const ContactConstraints::Row& row) {
    return dents_[static_cast<std::size_t>(row.place * kMaxInstruments + row.tool)];
  }
  void EndLocalParts(ContactConstraints* contacts);
  void SetToRest();

  PronySeries prony_;
  MaxwellStep step_;                           // the last one
  std::shared_ptr<ElasticSupports> supports_;  // none, or of the relaxation around which this is
  MaxwellState<Points> state_;
  std::array<Points, PronySeries::kMaxTerms> strains_;  // P W_k with elastic supports
  Points from_;                                         // n x 3, m: where the damper holds U
  Points free_;   // n x 3, m: U of a quadratic energy without forces
  Points start_;  // n x 3, m: U at the beginning of the step
  std::array<Dent, kMaxInstruments * kMaxPlaces> dents_;  // [place * kMaxInstruments + tool]
  std::array<Held, kMaxInstruments> held_;
  std::array<LocalPart, kMaxContacts> local_;
  std::array<int, kMaxContacts> place_{};                    // of a footprint's row
  std::array<LocalIndentation, kMaxContacts> indentations_;  // of the rows, after relaxation
};

}  // namespace hpdm
