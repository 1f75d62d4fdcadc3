#include "tools/haptics/shipped_contacts.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/mesh/collision.h"
#include "tools/session/device_choice.h"

namespace hpdm {
namespace {

constexpr double kReferenceDepth = 0.005;   // m
constexpr double kReferenceForce = 1;       // N
constexpr double kReferenceRigidForce = 2;  // N
constexpr double kClosedDepth = 0.002;      // m: of the tip as the jaws close
constexpr double kReachFrom = 0.004;        // m
constexpr double kReachSpeed = 0.02;        // m/s
constexpr double kTangentMove = 1e-6;       // m, of the difference that gives a stiffness

struct ContactSite {
  Vector3d p_W;
  Vector3d normal_W;
};

// Returns the vertex that the straight shaft meets most squarely past all other tissue.
std::optional<ContactSite> SquarestSite(const Session& session, const InstrumentOptions& instrument,
                                        int organ) {
  std::vector<SurfaceTree> trees;
  for (const OrganModel& each : session.organs()) {
    trees.emplace_back(each.rest().vertices, each.rest().triangles);
  }
  const OrganModel& model = session.organs()[static_cast<std::size_t>(organ)];
  const DeviceProfile& device = instrument.device;
  std::optional<ContactSite> best;
  double squarest = 0;
  for (Eigen::Index v = 0; v < model.rest().vertices.rows(); ++v) {
    const ContactSite site{model.rest().vertices.row(v), model.rest_normals().row(v)};
    const Vector3d p_tip_W = site.p_W + 1.01 * instrument.geometry.tip_radius * site.normal_W;
    const Vector3d shaft_W = instrument.p_trocar_W - p_tip_W;
    const double lever = shaft_W.norm(), square = shaft_W.dot(site.normal_W) / lever;
    if (square <= squarest || lever < device.min_insertion || lever > device.max_insertion ||
        std::any_of(trees.begin(), trees.end(), [&](const SurfaceTree& tree) {
          return tree.FirstEntry(instrument.p_trocar_W, p_tip_W).at.triangle >= 0;
        })) {
      continue;
    }
    squarest = square;
    best = site;
  }
  return best;
}

// Brings the tip to the reference pose and fills in what is found there. False without contact.
bool Reach(ShippedContact* contact) {
  const TimingOptions& timing = contact->session->scene().timing;
  const DisplayConditions display{.period = 1.0 / timing.haptic_hz};
  ContactLoop loop(*contact, display, 0, 1, true);
  const double most = contact->rigid ? kReferenceRigidForce : kReferenceForce;
  if (contact->grasps) {
    loop.plant().SetJaw(1);
    loop.Hold(kReachFrom, 0, kReachSpeed);
    loop.Rest(0.2);
    loop.plant().SetJaw(0);
    loop.Rest(0.2);
  } else {
    loop.Hold(-kReachFrom, 0, kReachSpeed);
  }
  double x = 0;
  const auto force = [&] { return -loop.plant().force(); };
  for (; x < kReferenceDepth && force() < most; x += kReachSpeed * loop.period()) {
    loop.plant().Hold(x);
    loop.Tick();
  }
  loop.Rest(0.5);
  contact->depth = x;
  contact->force = force();
  contact->patches = loop.patches();
  contact->stiffness = (StaticForce(*contact, contact->patches, x + kTangentMove) -
                        StaticForce(*contact, contact->patches, x - kTangentMove)) /
                       (2 * kTangentMove);
  const SolvedContact& main = contact->patches.main();
  return main.organ == contact->organ && contact->force > 0 && contact->stiffness > 0 &&
         (main.kind == ContactKind::kGrasp) == contact->grasps;
}

}  // namespace

std::shared_ptr<const Session> ContactSession(const std::filesystem::path& path, int haptic_hz,
                                              double delay) {
  Scene scene = LoadScene(path);
  if (haptic_hz > 0) {
    scene.timing.haptic_hz = haptic_hz;
    scene.timing.deformation_hz = std::min(scene.timing.deformation_hz, haptic_hz);
    scene.timing.patch_delay_ticks =
        (haptic_hz + scene.timing.deformation_hz - 1) / scene.timing.deformation_hz;
  }
  for (InstrumentOptions& instrument : scene.instruments) {
    if (delay >= 0) instrument.device.delay = delay;
  }
  return std::make_shared<const Session>(scene);
}

std::vector<ShippedContact> FindContacts(const std::shared_ptr<const Session>& session) {
  const Scene& scene = session->scene();
  std::vector<ShippedContact> contacts;
  for (std::size_t i = 0; i < scene.instruments.size(); ++i) {
    const InstrumentOptions& instrument = scene.instruments[i];
    const bool grasps = instrument.type == InstrumentType::kGrasper;
    for (std::size_t o = 0; o < session->organs().size(); ++o) {
      const OrganModel& organ = session->organs()[o];
      const bool own = organ.options().name == instrument.hand.organ;
      if (grasps && (!own || organ.rigid())) continue;
      std::optional<ContactSite> site;
      if (own) {
        const HandSite hand = session->SiteOf(instrument);
        site = ContactSite{hand.p_target_W, hand.normal_W};
      } else {
        site = SquarestSite(*session, instrument, static_cast<int>(o));
      }
      if (!site) continue;
      const double radius = instrument.geometry.tip_radius;
      ShippedContact contact{
          .name =
              scene.path.stem().string() + ": " + instrument.name + " on " + organ.options().name,
          .session = session,
          .instrument = static_cast<int>(i),
          .organ = static_cast<int>(o),
          .grasps = grasps,
          .rigid = organ.rigid(),
          .p_touch_W = site->p_W + (radius - (grasps ? kClosedDepth : 0)) * site->normal_W,
          .way_W = grasps ? site->normal_W : Vector3d(-site->normal_W),
          .kinematics = {instrument.p_trocar_W, site->p_W - instrument.p_trocar_W,
                         instrument.device}};
      if (Reach(&contact)) contacts.push_back(std::move(contact));
    }
  }
  return contacts;
}

}  // namespace hpdm
