#pragma once

#include <vector>

#include "engine/attachment/attachment_bed.h"

namespace hpdm {

/// Returns the force of each bed's layer on its organ b at the start, N, by which it bears its part of
/// the organs' weight (attachment_state.h); zero without gravity. Set-up only: it inverts the stiffness
/// of the organs. Throws InputError with its place if the weight would damage a layer.
std::vector<Vector3d> BorneWeight(const std::vector<OrganModel>& organs,
                                  const std::vector<AttachmentBed>& beds);

}  // namespace hpdm
