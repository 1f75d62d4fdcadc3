#include "tools/session/contact_stiffness.h"

#include <algorithm>
#include <utility>

#include "engine/base/text_list.h"
#include "engine/solver/elastic_supports.h"
#include "engine/step/tip_press.h"
#include "tools/shared/report_text.h"

namespace hpdm {

Eigen::VectorXd ContactStiffness(const OrganModel& organ, const InstrumentOptions& instrument) {
  const SurfaceMesh& rest = organ.rest();
  const int count = static_cast<int>(rest.vertices.rows());
  Eigen::VectorXd stiffness(count);
  std::unique_ptr<Relaxation> relaxation;
  if (instrument.reaction == ReactionType::kLattice && organ.lattice_organ() != nullptr) {
    relaxation = organ.MakeRelaxation(organ.RefinementSlots(1));
  }
  if (relaxation == nullptr || relaxation->compliance() == nullptr) {
    Eigen::VectorXi corners = Eigen::VectorXi::Zero(count);  // = neighbours in a closed surface
    for (Eigen::Index i = 0; i < rest.triangles.size(); ++i) ++corners[rest.triangles.data()[i]];
    for (int v = 0; v < count; ++v) {
      const int neighbours = std::min(corners[v], ReactionNode::kMaxNeighbours);
      stiffness[v] = instrument.k1 + neighbours * instrument.k2;
    }
    return stiffness;
  }
  const double instantaneous = organ.options().material.prony.InstantaneousFactor();
  const ScalarStiffness& springs = organ.lattice_organ()->elastic_supports();
  std::optional<ElasticSupports> supports;
  if (springs.size() > 0) {
    supports.emplace(*relaxation->compliance(), springs,
                     organ.control_points() + organ.RefinementSlots(1));
  }
  const double radius = std::max(instrument.geometry.tip_radius, TipPress::kMinKernelRadius);
  for (int v = 0; v < count; ++v) {
    const SurfacePoint at = organ.topology().AtVertex(rest.triangles, v);
    Matrix3d C = relaxation->compliance()->PointCompliance(organ.LatticeRow(v)) +
                 organ.Indentation(at, radius).Compliance();
    if (supports) {
      C += (instantaneous - 1) * supports->InSeries(organ.LatticeRow(v), instantaneous - 1);
    }
    const Vector3d n = organ.rest_normals().row(v);
    stiffness[v] = instantaneous / n.dot(C * n);
  }
  return stiffness;
}

Matrix3d DeepCompliance(const ToolPatch& patch) {
  const double f_n = std::max(0.0, -patch.normal_W.dot(patch.force_on_tissue_W));
  return patch.compliance_W - patch.indentation.UnderBall(f_n).Compliance() +
         patch.indentation.Compliance();
}

std::optional<StiffestContact> FindStiffestContact(const OrganModel& organ,
                                                   const InstrumentOptions& instrument,
                                                   const ImpulseEngineKinematics& kinematics,
                                                   double period, double delay) {
  const Eigen::VectorXd stiffness = ContactStiffness(organ, instrument);
  const std::array<StiffnessLimit, 3> limits =
      StiffnessLimits(AxesOf(instrument.device), period, delay);
  std::optional<StiffestContact> worst;
  double greatest = 0;
  for (Eigen::Index v = 0; v < stiffness.size(); ++v) {
    const Vector3d p_W = organ.rest().vertices.row(v), n_W = organ.rest_normals().row(v);
    if (n_W.dot(kinematics.p_trocar_W() - p_W) <= 0) continue;
    const auto pose = kinematics.Inverse(p_W + instrument.geometry.tip_radius * n_W, 0, 1);
    if (!pose.reachable) continue;
    greatest = std::max(greatest, stiffness[v]);
    const Matrix3d J = kinematics.Jacobian(pose.joints);
    for (int axis = 0; axis < 3; ++axis) {
      const double g = J.col(axis).squaredNorm(), along = J.col(axis).dot(n_W);
      const StiffnessLimit& limit = limits[axis];
      const StiffestContact contact{.stiffness = stiffness[v] * along * along / g,
                                    .limit = {limit.passivity / g, limit.stability / g},
                                    .axis = axis,
                                    .p_W = p_W};
      if (!worst || std::pair(contact.Ratio(), contact.stiffness) >
                        std::pair(worst->Ratio(), worst->stiffness)) {
        worst = contact;
      }
    }
  }
  if (worst) worst->greatest = greatest;
  return worst;
}

std::string StiffnessRemark(const std::string& instrument, const std::string& organ,
                            const StiffestContact& contact) {
  if (!(contact.Ratio() > 1)) return "";
  const bool unstable = contact.stiffness > contact.limit.stability;
  return Format(
      "instrument \"%s\": organ \"%s\" has a stiffness of up to %.0f N/m (%s, at [%.3f, %.3f, "
      "%.3f]), but the device displays at most %.0f N/m %s; soften the material, raise "
      "timing.haptic_hz or give instrument.device more %s",
      instrument.c_str(), organ.c_str(), contact.stiffness, AxisName(contact.axis), contact.p_W.x(),
      contact.p_W.y(), contact.p_W.z(),
      unstable ? contact.limit.stability : contact.limit.passivity,
      unstable ? "stably without a damping hand" : "passively",
      unstable || contact.limit.passivity > 0.99 * contact.limit.stability ? "damping"
                                                                           : "damping or friction");
}

std::string FaintRemark(const std::string& instrument, const std::string& organ,
                        const StiffestContact& contact) {
  constexpr double kFelt = 0.05 / 0.01;  // N/m
  if (contact.greatest >= kFelt) return "";
  return Format(
      "instrument \"%s\": organ \"%s\" resists with at most %.1f N/m: nothing will be felt; add an "
      "[[organ.support]] or raise material.young",
      instrument.c_str(), organ.c_str(), contact.greatest);
}

std::string TrocarRemark(const InstrumentOptions& instrument, double period) {
  const DeviceAxes axes = AxesOf(instrument.device);
  const auto displays = [&](int axis) {
    return PassivityBound(axes.damping[axis], axes.friction[axis], axes.encoder_step[axis], period,
                          instrument.device.delay) > 0;
  };
  std::string keys;
  if (instrument.trocar_friction > 0 && !displays(kInsertion)) {
    AppendToList("trocar_friction", &keys, " and no ");
  }
  if (instrument.trocar_torque > 0 && !(displays(kPitch) && displays(kYaw))) {
    AppendToList("trocar_torque", &keys, " and no ");
  }
  if (keys.empty()) return "";
  return "instrument \"" + instrument.name + "\": the device displays no " + keys +
         "; give instrument.device damping and friction on the same axes";
}

const char* AxisName(int axis) {
  static constexpr const char* kNames[] = {"pitch", "yaw", "insertion"};
  return kNames[axis];
}

}  // namespace hpdm
