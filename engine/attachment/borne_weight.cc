#include "engine/attachment/borne_weight.h"

#include <algorithm>
#include <array>
#include <memory>

#include "engine/attachment/attachment_state.h"

namespace hpdm {

std::vector<Vector3d> BorneWeight(const std::vector<OrganModel>& organs,
                                  const std::vector<AttachmentBed>& beds) {
  std::vector<Vector3d> borne_W(beds.size(), Vector3d::Zero());
  if (beds.empty() || organs[0].options().gravity_W.isZero(0)) return borne_W;
  std::vector<std::unique_ptr<Relaxation>> relaxations(organs.size());
  std::vector<std::array<AttachmentJoint::Organ, 2>> pairs;
  for (const AttachmentBed& bed : beds) {
    std::array<AttachmentJoint::Organ, 2>& pair = pairs.emplace_back();
    for (std::size_t o = 0; o < organs.size(); ++o) {
      const std::string& name = organs[o].options().name;
      if (name != bed.options.a && name != bed.options.b) continue;
      if (!relaxations[o]) relaxations[o] = organs[o].MakeRelaxation(0);
      pair[name == bed.options.a ? 0 : 1] =
          JoinedOrgan(static_cast<int>(o), organs[o], *relaxations[o], organs[o].control_points());
    }
  }
  for (const auto& joint : JoinOrgans(beds, pairs)) {
    const AttachmentState state(joint);
    std::vector<AttachmentOutcome> outcomes(joint->layers().size());
    state.Report(Eigen::VectorXd::Zero(3 * joint->modes()), outcomes);
    for (std::size_t l = 0; l < outcomes.size(); ++l) {
      borne_W[ToSize(joint->layers()[l].bed.index)] = outcomes[l].load_W;
    }
  }
  return borne_W;
}

}  // namespace hpdm
