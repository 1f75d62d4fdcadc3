#include "engine/solver/viscous_recovery.h"

#include <algorithm>
#include <cmath>

namespace hpdm {

ViscousRecovery::ViscousRecovery(double relaxation_time, int n)
    : relaxation_time_(relaxation_time), U_(Points::Zero(n, 3)), free_(U_) {}

void ViscousRecovery::Begin(double dt, const Relaxation& relaxation,
                            const ContactConstraints& contacts, RelaxationInput* input) {
  if (relaxation_time_ <= 0) return;
  constexpr double kMinStep = 1e-4;
  const double elapsed = std::max(dt, kMinStep) / relaxation_time_;
  if (contacts.size() > 0 && !relaxation.IsQuadratic(input->quality)) {
    input->damping = 1 / std::expm1(elapsed);  // e / (1 - e)
    input->damped_from = &U_;
    return;
  }
  free_ = std::exp(-elapsed) * U_;
  input->free = &free_;
  input->yield = -std::expm1(-elapsed);  // 1 - e, also where e is almost 1
}

void ViscousRecovery::End(const ContactConstraints& contacts, Points* U) {
  if (relaxation_time_ <= 0) return;
  if (contacts.size() == 0 && U->isZero(kStill)) U->setZero();
  U_ = *U;
  if (!U_.allFinite()) U_.setZero();  // the caller reports it; the next step starts at rest
}

RelaxationResult ViscousRecovery::Relax(double dt, Relaxation* relaxation,
                                        ContactConstraints* contacts, Points* U,
                                        RelaxationInput input) {
  Begin(dt, *relaxation, *contacts, &input);
  const RelaxationResult result = relaxation->Relax(contacts, U, input);
  End(*contacts, U);
  return result;
}

}  // namespace hpdm
