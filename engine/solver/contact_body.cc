#include "engine/solver/contact_body.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/base/check.h"

namespace hpdm {

void RelaxTogether(std::span<BodyInStep> bodies, std::span<OrganContact> pairs,
                   ContactSolver* solver, std::span<BodyLink* const> links) {
  HPDM_CHECK(bodies.size() <= ContactSolver::kMaxBodies);
  std::array<const ContactConstraints*, ContactSolver::kMaxBodies> contacts;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    contacts[b] = bodies[b].contacts;
    bodies[b].body->Begin(bodies[b].input, *contacts[b]);
  }
  // Quadratic bodies have the same part in all rounds, and move only once the links have settled.
  const bool quadratic =
      std::ranges::all_of(bodies, [](const BodyInStep& body) { return body.body->IsQuadratic(); });
  RelaxationResult solved;
  bool goes_on = true;
  for (bool first = true, settled = false; goes_on && !settled; first = false) {
    if (first || !quadratic) {
      solver->Build(std::span(contacts.data(), bodies.size()), pairs);
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        goes_on = bodies[b].body->Linearise(static_cast<int>(b), *contacts[b], solver) && goes_on;
      }
      if (!goes_on) break;
      if (quadratic && !links.empty()) solver->Keep();
    } else {
      solver->TakeBack();
    }
    for (BodyLink* link : links) link->Linearise(bodies, solver);
    solved = solver->Solve();
    settled = true;
    for (BodyLink* link : links) settled = link->Advance(*solver) && settled;
    if (quadratic && !settled) continue;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      solver->WriteForces(static_cast<int>(b), bodies[b].contacts);
      settled =
          bodies[b].body->Advance(static_cast<int>(b), *bodies[b].contacts, *solver) && settled;
    }
    solver->WriteForces(pairs);
  }
  for (BodyInStep& body : bodies) body.result = body.body->End(solved, body.U);
  for (BodyLink* link : links) link->End(bodies);
  for (BodyInStep& body : bodies) body.body->TakeMoved(body.U);
  for (BodyLink* link : links) link->Follow(bodies);
}

RelaxationResult BodyRelaxation::DoRelax(const RelaxationInput& input, ContactConstraints* contacts,
                                         Points* U) {
  if (alone_ == nullptr) alone_ = std::make_unique<ContactSolver>();
  BodyInStep body{this, contacts, U, input};
  RelaxTogether({&body, 1}, {}, alone_.get());
  return body.result;
}

}  // namespace hpdm
