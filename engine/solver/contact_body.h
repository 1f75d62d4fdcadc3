#pragma once

#include <memory>
#include <span>

#include "engine/contact/contact_solver.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// One organ in the contact problem of one step, which may hold several (ContactSolver). Near its
/// present state its displacements follow the forces f on its rows,
///     U = U_free + R f,
/// exactly if its energy is quadratic; otherwise in rounds. Deformation thread; allocates nothing.
class ContactBody {
 public:
  virtual ~ContactBody() = default;

  /// True if its part of the problem is the same in all rounds of a step.
  virtual bool IsQuadratic() const { return false; }

  /// Starts a step. `contacts`: its rows, complete.
  virtual void Begin(const RelaxationInput& input, const ContactConstraints& contacts) = 0;

  /// Adds its part of the compliance to the problem, in which it is number `body`, and takes its
  /// free displacements off the changes. False if its rounds have ended: none of them follows.
  virtual bool Linearise(int body, const ContactConstraints& contacts, ContactSolver* solver) = 0;

  /// Moves under the forces that `solver` found. `contacts`: with these forces. True if it is in
  /// equilibrium with them.
  virtual bool Advance(int body, const ContactConstraints& contacts,
                       const ContactSolver& solver) = 0;

  /// Ends the step: fills U and returns its own result. `solved`: that of the last problem.
  virtual RelaxationResult End(const RelaxationResult& solved, Points* U) = 0;

  /// The displacements of this step without forces, (n + slots) x 3, m, for the links; nullptr: zero.
  virtual const Points* FreeDisplacements() const { return nullptr; }
  /// Takes the step's displacements, to which the links have added theirs. A body that moves as a
  /// whole replaces them by those of its new frame.
  virtual void TakeMoved(Points* /*U*/) {}
  /// For a body that moves as a whole: links act on it in its moving frame from now on.
  virtual void Tie() {}
  /// Return the frame X_WF of a tied body: the one that it would reach in this step without forces, and
  /// the one of its last step's end. A point p at rest is at X_WF p. All others return the identity.
  virtual Isometry3d PredictedFrame() const { return Isometry3d::Identity(); }
  virtual Isometry3d Frame() const { return Isometry3d::Identity(); }
  /// Takes the step back: its solution was rejected, and Begin() follows once more.
  virtual void TakeBack() {}
  /// For a body that moves as a whole: links hold it (true), or have let it go. At first none does.
  virtual void SetHeld(bool /*held*/) {}
};

/// A body with its data in one step.
struct BodyInStep {
  ContactBody* body = nullptr;
  ContactConstraints* contacts = nullptr;
  Points* U = nullptr;  ///< (n + slots) x 3, m.
  RelaxationInput input = {};
  RelaxationResult result = {};
};

/// Layers that join bodies of one problem (engine/attachment/attachment_link.h). Deformation thread;
/// allocates nothing.
class BodyLink {
 public:
  virtual ~BodyLink() = default;
  /// Changes the problem by the layers' part, after all bodies have added theirs.
  virtual void Linearise(std::span<const BodyInStep> bodies, ContactSolver* solver) = 0;
  /// Takes the forces found. True if the layers' stiffness need not change.
  virtual bool Advance(const ContactSolver& solver) = 0;
  /// Ends the step: adds the displacements by the layers to those of the bodies.
  virtual void End(std::span<BodyInStep> bodies) = 0;
  /// Takes the bodies' final places.
  virtual void Follow(std::span<const BodyInStep> bodies) = 0;
};

/// Solves the contacts of all `bodies` and of the `pairs` between them as one problem, in rounds
/// until all are in equilibrium, the `links` included. Fills U, the results and the forces of rows
/// and pairs. `solver` is working memory. Deformation thread; allocates nothing.
void RelaxTogether(std::span<BodyInStep> bodies, std::span<OrganContact> pairs,
                   ContactSolver* solver, std::span<BodyLink* const> links = {});

/// A relaxation whose organ can be a body of a problem with others.
class BodyRelaxation : public Relaxation, public ContactBody {
 public:
  BodyRelaxation() = default;
  BodyRelaxation(const BodyRelaxation& other) : Relaxation(other), ContactBody(other) {}
  // alone_ is working memory.
  BodyRelaxation& operator=(const BodyRelaxation&) { return *this; }
  ContactBody* body() final { return this; }

 private:
  RelaxationResult DoRelax(const RelaxationInput& input, ContactConstraints* contacts,
                           Points* U) final;
  std::unique_ptr<ContactSolver> alone_;  // of Relax(), working memory
};

}  // namespace hpdm
