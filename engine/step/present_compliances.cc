#include "engine/step/present_compliances.h"

namespace hpdm {

PresentCompliances::PresentCompliances(std::span<const AttachmentLink> links,
                                       AttachedCompliance::Work* work,
                                       std::vector<OrganStep>* organs)
    : organs_(organs) {
  for (std::size_t o = 0; o < organs->size(); ++o) {
    OrganState& state = (*organs)[o].state();
    const LatticeCompliance* own = state.relaxation->compliance();
    state.present_compliance = own;
    if (own == nullptr) continue;
    for (const AttachmentLink& link : links) {
      const int member = link.joint().MemberOf(static_cast<int>(o));
      if (member < 0) continue;
      const bool let_go = link.HasLetGo(ToSize(member));
      if (let_go && !link.HasDucts(ToSize(member))) continue;
      state.present_compliance =
          &attached_[o].emplace(*own, link.state(), member, work,
                                let_go ? state.relaxation->Rotation() : Matrix3d::Identity());
    }
  }
}

PresentCompliances::~PresentCompliances() {
  for (OrganStep& organ : *organs_) organ.state().present_compliance = nullptr;
}

}  // namespace hpdm
