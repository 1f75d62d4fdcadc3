#include "tools/session/support_relaxation.h"

#include <algorithm>
#include <vector>

#include "tools/session/contact_stiffness.h"
#include "tools/shared/report_text.h"

namespace hpdm {

std::optional<SupportRelaxation> MeasureSupportRelaxation(const OrganModel& organ,
                                                          const InstrumentOptions& instrument) {
  OrganOptions at_once = organ.options();
  const double factor = at_once.material.prony.InstantaneousFactor();
  const bool has_springs =
      std::any_of(at_once.supports.begin(), at_once.supports.end(),
                  [](const SupportOptions& support) { return support.stiffness.has_value(); });
  if (organ.lattice_organ() == nullptr || at_once.material.prony.count == 0 || !has_springs) {
    return std::nullopt;
  }
  at_once.material.prony = {};
  at_once.material.young *= factor;
  for (StiffnessRegion& region : at_once.regions) region.young *= factor;
  at_once.energy.alpha *= factor;
  at_once.energy.beta *= factor;
  const Eigen::VectorXd exact = ContactStiffness(OrganModel(at_once, organ.rest()), instrument);
  const Eigen::VectorXd excess =
      ContactStiffness(organ, instrument).cwiseQuotient(exact).array() - 1;
  std::vector<double> sorted(excess.begin(), excess.end());
  std::sort(sorted.begin(), sorted.end());
  return SupportRelaxation{sorted[sorted.size() / 2], sorted[sorted.size() * 95 / 100]};
}

std::string SupportRemark(const std::string& organ, const SupportRelaxation& relaxation) {
  constexpr double kAnnounced = 0.1;
  if (!(relaxation.greatest > kAnnounced)) return "";
  return Format(
      "organ \"%s\": its supports with a stiffness relax with the tissue; at once it is %.0f %% "
      "(median) to %.0f %% stiffer than on elastic supports; give them fixed = true or a greater "
      "stiffness, or less prony share",
      organ.c_str(), 100 * relaxation.median, 100 * relaxation.greatest);
}

}  // namespace hpdm
