#include "render/tissue/burn_marks.h"

#include <algorithm>

namespace hpdm {

BurnMarks::BurnMarks(const std::vector<int>& vertices) {
  for (const int count : vertices) black_.emplace_back(ToSize(count), 0.0f);
}

bool BurnMarks::Follow(const SceneSnapshot& snapshot) {
  const double dt = std::clamp(ToSeconds(snapshot.step.time_ns - last_ns_), 0.0, kLongest);
  last_ns_ = snapshot.step.time_ns;
  bool grows = false;
  for (std::size_t t = 0; t < ToSize(snapshot.tool_count); ++t) {
    const SolvedContact& contact = snapshot.contacts[t];
    if (!snapshot.burns[t] || contact.kind != ContactKind::kPress) continue;
    if (contact.organ < 0 || ToSize(contact.organ) >= black_.size()) continue;
    const OrganSnapshot& organ = snapshot.organs[ToSize(contact.organ)];
    std::vector<float>& black = black_[ToSize(contact.organ)];
    const Eigen::RowVector3f p = (contact.contact_W - organ.offset_W).cast<float>();
    for (std::size_t v = 0; v < black.size(); ++v) {
      const double distance = (organ.vertices.row(static_cast<Eigen::Index>(v)) - p).norm();
      if (distance >= kReach || black[v] >= 1) continue;
      const double added = dt / kTime * (1 - distance / kReach);
      black[v] = std::min(1.0f, black[v] + static_cast<float>(added));
      grows = grows || added > 0;
    }
  }
  return grows;
}

}  // namespace hpdm
