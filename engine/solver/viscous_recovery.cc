#include "engine/solver/viscous_recovery.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace hpdm {

ViscousRecovery::ViscousRecovery(double relaxation_time, int n)
    : relaxation_time_(relaxation_time), U_(Points::Zero(n, 3)), V_(U_) {}

RelaxationResult ViscousRecovery::Relax(double dt, Relaxation* relaxation,
                                        ContactConstraints* contacts, Points* U,
                                        RelaxationInput input) {
  if (relaxation_time_ <= 0) return relaxation->Relax(contacts, U, input);
  constexpr double kMinStep = 1e-4;
  const double elapsed = std::max(dt, kMinStep) / relaxation_time_;
  if (contacts->size() > 0 && !relaxation->IsQuadratic(input.quality)) {
    input.damping = 1 / std::expm1(elapsed);  // e / (1 - e)
    input.damped_from = &U_;
    const RelaxationResult result = relaxation->Relax(contacts, U, input);
    U_ = *U;
    if (!U_.allFinite()) U_.setZero();
    return result;
  }
  const double e = std::exp(-elapsed);
  const double done = -std::expm1(-elapsed);  // 1 - e, also where e is almost 1
  std::array<Vector3d, kMaxContacts> targets;
  std::array<Matrix3d, kMaxContacts> local_compliances;
  std::array<LocalIndentation, kMaxContacts> indentations;
  for (int i = 0; i < contacts->size(); ++i) {
    ContactConstraints::Row& row = (*contacts)[i];
    targets[i] = row.target_W;
    local_compliances[i] = row.local_compliance_W;
    row.local_compliance_W /= done;
    indentations[i] = row.indentation;
    row.indentation = row.indentation.Scaled(1 / done);
    row.coupled.factor = 1 / done;
    const Vector3d kept = e * (contacts->Weights().row(i) * U_).transpose();
    row.target_W = row.p_rest_W + (row.target_W - row.p_rest_W - kept) / done;
  }
  const RelaxationResult result = relaxation->Relax(contacts, &V_, input);
  for (int i = 0; i < contacts->size(); ++i) {
    (*contacts)[i].target_W = targets[i];
    (*contacts)[i].local_compliance_W = local_compliances[i];
    (*contacts)[i].indentation = indentations[i];
    (*contacts)[i].coupled.factor = 1;
    (*contacts)[i].slip *= done;
  }
  U_ = e * U_ + done * V_;
  if (contacts->size() == 0 && U_.isZero(kStill)) U_.setZero();
  *U = U_;
  if (!U_.allFinite()) {  // the caller reports it; the next step starts at rest
    U_.setZero();
    V_.setZero();
  }
  return result;
}

}  // namespace hpdm
