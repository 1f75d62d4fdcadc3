#include "tools/haptics/contact_loop.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/contact/surface_kernel.h"
#include "haptics/contact/tip_contacts.h"

namespace hpdm {
namespace {

// Above every force and slew.
constexpr double kUnlimitedForce = 1e9;

Vector3d Guide(const ShippedContact& contact, double x) {
  return contact.kinematics.Jacobian(JointsAt(contact, x)).inverse() * contact.way_W;
}

void Stiffen(const OrganModel& organ, double stiffer, ToolPatch* patch) {
  const auto stiffen_node = [stiffer](ReactionNode* node) {
    node->k1 *= stiffer;
    for (ReactionNode::Neighbour& neighbour : node->neighbours) neighbour.k2 *= stiffer;
  };
  const auto stiffen_points = [&](SurfacePatch* surface) {
    for (int i = 0; i < surface->point_count; ++i) {
      PatchPoint& point = surface->points[static_cast<std::size_t>(i)];
      point.compliance_W /= stiffer;
      point.coupling_W /= stiffer;
      point.wall.normal *= stiffer;
      point.wall.tangential *= stiffer;
    }
    for (int i = 0; i < surface->node_count; ++i) {
      stiffen_node(&surface->nodes[static_cast<std::size_t>(i)]);
    }
  };
  stiffen_points(patch);
  stiffen_points(&patch->far);
  stiffen_node(&patch->grasp_node);
  patch->force_on_tissue_W *= stiffer;
  patch->compliance_W /= stiffer;
  patch->coupling_W /= stiffer;
  patch->tilt_compliance_W /= stiffer;
  const LocalIndentation& indentation = patch->indentation;
  if (!indentation.indents()) return;
  MaterialOptions material =
      organ.MaterialAt(NearestSurfacePoint(organ.rest(), patch->p_original_W));
  material.young *= stiffer;
  patch->indentation = {material, indentation.normal_W(), indentation.radius(),
                        indentation.resolved_radius()};
}

TimingOptions TimingOf(const Scene& scene, Nanoseconds period_ns) {
  TimingOptions timing = scene.timing;
  timing.haptic_hz = static_cast<int>(std::lround(1e9 / static_cast<double>(period_ns)));
  timing.patch_delay_ticks = (timing.haptic_hz + timing.deformation_hz - 1) / timing.deformation_hz;
  return timing;
}

}  // namespace

JointVector JointsAt(const ShippedContact& contact, double x) {
  return contact.kinematics
      .Inverse(contact.p_touch_W + x * contact.way_W, 0, contact.grasps ? 0 : 1)
      .joints;
}

double EncoderStepAlong(const ShippedContact& contact, double x) {
  const Matrix3d J = contact.kinematics.Jacobian(JointsAt(contact, x));
  return (J.transpose() * contact.way_W)
      .cwiseAbs()
      .dot(AxesOf(InstrumentOf(contact).device).encoder_step);
}

StabilityPlantOptions GuidedDevice(const ShippedContact& contact, const DisplayConditions& display,
                                   double x) {
  const DeviceAxes device = AxesOf(InstrumentOf(contact).device);
  const Vector3d guide = Guide(contact, x);
  StabilityPlantOptions plant;
  plant.guide = guide;
  plant.axis.mass = device.inertia.dot(guide.cwiseAbs2());
  plant.axis.damping = device.damping.dot(guide.cwiseAbs2());
  if (!display.ideal) {
    plant.friction = device.friction.dot(guide.cwiseAbs());
    plant.encoder_step = device.encoder_step;
  }
  plant.push = 0;
  plant.period_ns = std::llround(1e9 * display.period);
  plant.delay_ns = std::llround(1e9 * display.delay);
  return plant;
}

ToolPatches Stiffened(const ToolPatches& patches, const std::vector<OrganModel>& organs,
                      double stiffer) {
  ToolPatches result = patches;
  if (stiffer == 1) return result;
  for (ToolPatch& patch : result.places) {
    if (patch.organ >= 0) Stiffen(organs[static_cast<std::size_t>(patch.organ)], stiffer, &patch);
  }
  return result;
}

double StaticForce(const ShippedContact& contact, const ToolPatches& patches, double x) {
  const InstrumentOptions& instrument = InstrumentOf(contact);
  const JointVector joints = JointsAt(contact, x);
  TipContacts tip;
  tip.SetPatches(patches);
  tip.Locate({.X_WT = contact.kinematics.Forward(joints),
              .jaw = joints[kJaw],
              .tip_radius = instrument.geometry.tip_radius,
              .friction = instrument.geometry.friction});
  TipContacts::Solve(&tip);
  return -contact.way_W.dot(tip.result().reaction_W);
}

StabilityPlantOptions ContactLoop::PlantOptions(const DisplayConditions& display,
                                                double origin) const {
  const HandOptions& hand = InstrumentOf(contact_).hand;
  StabilityPlantOptions plant = GuidedDevice(contact_, display, origin);
  plant.axis.damping += display.hand * hand.damping;
  plant.axis.stiffness = display.hand * hand.stiffness;
  return plant;
}

HapticInstrument ContactLoop::Instrument(const DisplayConditions& display) {
  HapticInstrument instrument =
      contact_.session->HapticInstruments()[static_cast<std::size_t>(contact_.instrument)];
  instrument.device = &plant_;
  instrument.kinematics = contact_.kinematics;
  instrument.passivity.control = display.control;
  instrument.guard.ramp_in = 1e-9;  // the start of a session is not measured here
  if (!live_) {
    instrument.guard.stale_age_ns = std::numeric_limits<Nanoseconds>::max();
    // An energy tank would take the force of a contact that vibrates: what is stable would not be displayed.
    instrument.passivity.still = false;
  }
  if (!display.guard) {
    instrument.guard.max_force = kUnlimitedForce;
    instrument.guard.max_torque = kUnlimitedForce;
    instrument.guard.max_force_rate = kUnlimitedForce;
  }
  if (display.ideal) {
    instrument.passivity.device.friction.setZero();
    instrument.passivity.device.encoder_step.setZero();
  }
  return instrument;
}

ContactLoop::ContactLoop(const ShippedContact& contact, const DisplayConditions& display,
                         double origin, double stiffer, bool live)
    : contact_(contact),
      stiffer_(stiffer),
      live_(live),
      period_ns_(std::llround(1e9 * display.period)),
      axis_(PlantOptions(display, origin).axis),
      plant_(PlantOptions(display, origin), JointsAt(contact, origin)),
      patches_(std::make_unique<TripleBuffer<ContactPatch>>()),
      haptics_({Instrument(display)}, period_ns_, {tool_states_, *patches_, samples_}) {
  plant_.Home();
  plant_.EnableForce(true);
  if (live) {
    steps_ = std::make_unique<Steps>(contact, TimingOf(contact.session->scene(), period_ns_),
                                     &haptics_, &tool_states_);
    return;
  }
  ContactPatch& patch = patches_->Back();
  patch.step.number = 1;
  patch.tool_count = 1;
  patch.tools[0] = Stiffened(contact.patches, contact.session->organs(), stiffer);
  patches_->Publish();
}

ContactLoop::Steps::Steps(const ShippedContact& contact, const TimingOptions& timing,
                          HapticLoop* haptics, TripleBuffer<ToolState>* tool_states)
    : scenes(SizedSnapshot(contact.session->organs(), 1, false)),
      unread_scenes(scenes.Front()),
      deformation(
          contact.session->organs(),
          {contact.session->DeformationTools()[static_cast<std::size_t>(contact.instrument)]},
          {*tool_states, patches, unread_scenes, scenes}),
      clock(timing, haptics, &deformation) {}

void ContactLoop::PassPatches() {
  if (!steps_->patches.Update()) return;
  ContactPatch& passed = patches_->Back();
  passed = steps_->patches.Front();
  passed.tools[0] = Stiffened(passed.tools[0], contact_.session->organs(), stiffer_);
  patches_->Publish();
}

void ContactLoop::Tick() {
  if (!live_) {
    haptics_.Tick(tick_, static_cast<Nanoseconds>(tick_) * period_ns_, {});
    ++tick_;
    return;
  }
  if (steps_->clock.StepIfDue()) PassPatches();
  steps_->clock.Tick();
}

const ToolPatches& ContactLoop::patches() const {
  return live_ ? steps_->patches.Front().tools[0] : contact_.patches;
}

void ContactLoop::Hold(double from, double to, double speed) {
  const int ticks = std::max(1, static_cast<int>(std::abs(to - from) / (speed * period())));
  for (int i = 1; i <= ticks; ++i) {
    plant_.Hold(from + (to - from) * i / ticks);
    Tick();
  }
}

void ContactLoop::Rest(double seconds) {
  for (int i = 0; i < static_cast<int>(seconds / period()); ++i) Tick();
}

}  // namespace hpdm
