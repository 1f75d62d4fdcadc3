#pragma once

#include <string>
#include <vector>

#include "engine/organ_options.h"

namespace hpdm {

/// A layer of connective tissue between the facing surfaces of two organs, which tears for good
/// (cohesive_law.h).
struct AttachmentOptions {
  std::string name = {};       ///< Empty: LabelOf() names the organs.
  std::string a, b;            ///< Names of the organs.
  Region region;               ///< The layer covers the part of a's surface in it that b faces.
  double young = 0;            ///< Pa.
  double thickness = 0;        ///< m.
  double strength = 0;         ///< Pa: the largest traction.
  double toughness = 0;        ///< J/m^2: the energy that frees a unit of area.
  double reach = 0;            ///< m: the largest distance of facing points.
  double burn_energy = 1.9e6;  ///< J/m^2: the heat that burns a unit of area away.
};

/// Returns the attachment's name for people.
inline std::string LabelOf(const AttachmentOptions& attachment) {
  return attachment.name.empty() ? attachment.a + " and " + attachment.b : attachment.name;
}

/// Returns the toughness below which the traction would drop at once, J/m^2.
inline double LeastToughness(const AttachmentOptions& attachment) {
  return attachment.strength * attachment.strength * attachment.thickness / (2 * attachment.young);
}

/// True if the organ can be attached to another: its stiffness is constant and does not relax, or
/// it is rigid. A free organ can: it moves as a whole once nothing holds it.
inline bool TakesAttachments(const OrganOptions& organ) {
  return organ.model == OrganModelType::kRigid ||
         (organ.model == OrganModelType::kHpdm && organ.energy.solver == SolverType::kCholesky &&
          organ.energy.strain == StrainMeasure::kSmall && organ.material.prony.count == 0);
}

/// The remedy for an organ that TakesAttachments() refuses.
inline constexpr const char* kAttachmentRemedy =
    "use model = \"hpdm\" with strain = \"small\", solver = \"cholesky\", no prony, or model = "
    "\"rigid\"";

/// True if one of the attachments holds the organ.
inline bool IsAttached(const std::vector<AttachmentOptions>& attachments,
                       const std::string& organ) {
  for (const AttachmentOptions& attachment : attachments) {
    if (attachment.a == organ || attachment.b == organ) return true;
  }
  return false;
}

}  // namespace hpdm
