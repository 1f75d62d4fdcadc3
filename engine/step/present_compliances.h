#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "engine/attachment/attached_compliance.h"
#include "engine/attachment/attachment_link.h"
#include "engine/scene_limits.h"
#include "engine/step/organ_step.h"

namespace hpdm {

/// The organs' compliances while layers and ducts hold them with their present damage. As long as it
/// lives, OrganState::present_compliance points to them. Deformation thread; allocates nothing.
class PresentCompliances {
 public:
  /// All must outlive it.
  PresentCompliances(std::span<const AttachmentLink> links, AttachedCompliance::Work* work,
                     std::vector<OrganStep>* organs);
  ~PresentCompliances();
  PresentCompliances(const PresentCompliances&) = delete;
  PresentCompliances& operator=(const PresentCompliances&) = delete;

 private:
  std::vector<OrganStep>* organs_;
  std::array<std::optional<AttachedCompliance>, kMaxOrgans> attached_;
};

}  // namespace hpdm
