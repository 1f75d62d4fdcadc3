#pragma once

#include <memory>

#include "engine/solver/compliance_solver.h"
#include "engine/solver/free_body.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// Makes the relaxation of an organ without supports, a body of small strain in a floating frame:
///
/// 1. The displacements are U_a = p_W + R x_a - X_a + R V_a: the frame's rigid motion, exact in the
///    splines, and the deformation V in the frame.
/// 2. A step predicts the frame's free flight. The forces f of the step's contacts then act about
///    the prediction with the compliance R K^-1 R^T. K holds the inertia (FreeBody::AddInertia), so
///    the response has a rigid part q, as of impulses at the step's start, and a deformation.
/// 3. q moves from the displacements to the frame, which leaves V without a rigid part: the frame
///    is the mass-weighted best fit of the shape. q / dt is added to the velocities.
/// 4. So all contacts are implicit: bodies stop without a bounce. A step without forces is the exact
///    free flight. In one with forces gravity acts as an impulse too (FreeFlight::Impulse).
///
/// 5. While links hold the body (SetHeld), the frame stays at its rest pose and the motion is that of
///    small rotations, U = N q + V: the links' modes are constant. Gravity is in the links' loads. A
///    body that is let go keeps its place and velocity.
/// 6. Links can act on a body in its moving frame (Tie). Their part is added to the response before 3.
/// 7. RelaxationInput::free is a deformation in the frame, and has no rigid part: what a loss of fluid
///    leaves. It is added to V.
///
/// `K`: solver of the stiffness with AddInertia(flight.Yield()). `body` must outlive it; `rows`: n +
/// slots. A relaxation is one step of flight.dt(). An organ whose U is not finite returns to rest.
std::unique_ptr<Relaxation> MakeFreeRelaxation(std::unique_ptr<ComplianceSolver> K,
                                               const FreeBody& body, const FreeFlight& flight,
                                               Eigen::Index rows);

}  // namespace hpdm
