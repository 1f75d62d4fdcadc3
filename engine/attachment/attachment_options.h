#pragma once

#include <array>
#include <string>
#include <vector>

#include "engine/organ_options.h"

namespace hpdm {

/// A layer of connective tissue between the facing surfaces of two organs, or a leaf, a sheet that spans
/// the way between two lines on their surfaces. Both tear for good (cohesive_law.h).
struct AttachmentOptions {
  std::string name = {};   ///< Empty: LabelOf() names the organs.
  std::string label = {};  ///< What it is to an exercise, such as "bed"; or empty.
  std::string a, b;        ///< Names of the organs.
  Region region;           ///< The layer covers the part of a's surface in it that b faces.
  double young = 0;        ///< Pa.
  double thickness = 0;    ///< m.
  double strength = 0;     ///< Pa: the largest traction; of a leaf the largest stress.
  /// J/m^2: the energy that frees a unit of area; of a leaf that tears a unit of its cross-section.
  double toughness = 0;
  double reach = 0;  ///< m: the largest distance of facing points, or of a line from its surface.
  double burn_energy = 1.9e6;  ///< J/m^2: the heat that burns a unit of area away.
  /// m, of a leaf: its lines on a and on b in the world at rest, both in the same direction. Else empty.
  std::array<std::vector<Vector3d>, 2> paths_W = {};

  bool IsLeaf() const { return !paths_W[0].empty(); }
};

/// Returns the attachment's name for people.
inline std::string LabelOf(const AttachmentOptions& attachment) {
  return attachment.name.empty() ? attachment.a + " and " + attachment.b : attachment.name;
}

/// Returns the toughness below which the traction would drop at once, J/m^2. `length`: m, over which
/// the tissue stretches: the layer's thickness, or the way that a leaf spans.
inline double LeastToughness(const AttachmentOptions& attachment, double length) {
  return attachment.strength * attachment.strength * length / (2 * attachment.young);
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
