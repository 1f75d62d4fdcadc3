#include "haptics/contact/tip_contacts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "tests/support/contact_patches.h"

namespace hpdm {
namespace {

constexpr double kTipRadius = 0.0025;  // m, of the tip
constexpr double kTipStiffness = 120;  // N/m
constexpr double kTipDepth = 0.003;    // m

// A plane at z = 0 with the given stiffness (N/m) everywhere.
ToolPatch SoftPlane(int organ, double stiffness) {
  ToolPatch patch = PlanePatch(7, 0.03, 0);
  patch.organ = organ;
  patch.reaction = ReactionType::kLattice;
  patch.compliance_W = Matrix3d::Identity() / stiffness;
  for (int i = 0; i < patch.point_count; ++i) patch.points[i].compliance_W = patch.compliance_W;
  return patch;
}

// A tick of a tip at kTipDepth.
HapticForce Tick(TipContacts* contacts, double x = 0.001) {
  contacts->Locate({.X_WT = Isometry3d(Eigen::Translation3d(x, 0.002, kTipRadius - kTipDepth)),
                    .tip_radius = kTipRadius});
  TipContacts::Solve(contacts);
  return contacts->result();
}

// The log's `kind`, `organ` and `depth` are those of the contact that presses. Otherwise the log would
// show two contacts where there is one, and its check would judge each half.
TEST(TipContacts, AContactThatFadesOutDoesNotHideOneThatPresses) {
  auto patches = std::make_unique<ToolPatches>();
  patches->places[0] = SoftPlane(0, 4 * kTipStiffness);
  patches->places[1] = SoftPlane(1, kTipStiffness);
  TipContacts contacts;
  contacts.SetPatches(*patches);
  for (int i = 0; i < 300; ++i) Tick(&contacts);
  EXPECT_EQ(contacts.result().organ, 0);
  const auto next = std::make_unique<ToolPatches>();
  next->places[1] = SoftPlane(1, kTipStiffness);
  contacts.SetPatches(*next);
  const HapticForce force = Tick(&contacts);
  EXPECT_GT(force.reaction_W.z(), 4 * kTipStiffness * kTipDepth) << "the first one fades out";
  EXPECT_EQ(force.kind, ContactKind::kPress);
  EXPECT_EQ(force.organ, 1);
  EXPECT_NEAR(force.depth, kTipDepth, 1e-12);
}

// Jaws carry a body on a spring of 0.2 N/m by 0.1 m. A force on it without the jaws would move it by decimetres.
TEST(TipContacts, APressOnACarriedBodyIsAsDeepAsItDentsTheBodyInTheJaws) {
  constexpr double kSpring = 5;  // m/N, of the whole body
  const auto body = [&](ToolPatch patch, PlaceId id, PlaceId other, double stiffness) {
    patch.id = id;
    patch.other = other;
    patch.coupling_W = kSpring * Matrix3d::Identity();
    patch.compliance_W = (kSpring + 1 / stiffness) * Matrix3d::Identity();
    for (int i = 0; i < patch.point_count; ++i) {
      patch.points[i].compliance_W = patch.compliance_W;
      patch.points[i].coupling_W = patch.coupling_W;
    }
    return patch;
  };
  const auto pressed = std::make_unique<ToolPatches>(), held = std::make_unique<ToolPatches>();
  pressed->places[0] = body(SoftPlane(0, kTipStiffness), 0, kToolPlaces, kTipStiffness);
  held->places[0] = body(SoftPlane(0, kTipStiffness), kToolPlaces, 0, 10 * kTipStiffness);
  held->places[0].kind = ContactKind::kGrasp;
  held->places[0].hold = 10;
  held->places[0].p_original_W = Vector3d(-0.01, 0, 0);
  TipContacts press, jaws;
  press.SetPatches(*pressed);
  jaws.SetPatches(*held);
  const std::array<TipContacts*, 2> tools = {&press, &jaws};
  const Vector3d carried(0.02, 0, 0.1);
  // The body follows the jaws but for what the spring's pull dents it.
  const Vector3d body_W = carried * kSpring / (kSpring + 0.1 / kTipStiffness);
  double depth = -kTipDepth;
  for (int tick = 0; tick < 900; ++tick) {
    const double share = std::min(1.0, tick / 500.0);
    if (tick > 600) depth = std::min(kTipDepth, depth + 5e-5);
    TipContacts::StandOnMoved(tools);
    const Vector3d tip_W = share * body_W + Vector3d(0.001, 0.002, kTipRadius - depth);
    press.Locate({.X_WT = Isometry3d(Eigen::Translation3d(tip_W)), .tip_radius = kTipRadius});
    const Vector3d jaws_W = share * carried + held->places[0].p_original_W;
    jaws.Locate({.X_WT = Isometry3d(Eigen::Translation3d(jaws_W)), .jaw = 0.1});
    TipContacts::Solve(tools);
    if (tick > 600 && depth > 0) EXPECT_NEAR(press.result().depth, depth, 1e-5) << tick;
  }
  const double dent = 1 / kTipStiffness + 0.1 / kTipStiffness;  // m/N, of both tips' tissue
  EXPECT_NEAR(press.result().reaction_W.z(), kTipDepth / dent, 0.01 * kTipDepth / dent);
}

// The lower side of a thin organ whose upper side is SoftPlane.
ToolPatch OtherSide() {
  ToolPatch patch = SoftPlane(0, kTipStiffness);
  for (int i = 0; i < patch.point_count; ++i) {
    patch.points[i].p_original_W.z() = -0.002;
    patch.points[i].normal_W = -Vector3d::UnitZ();
  }
  for (int t = 0; t < patch.triangle_count; ++t) {
    std::swap(patch.triangles[ToSize(t)][1], patch.triangles[ToSize(t)][2]);
    patch.mesh_triangles[ToSize(t)] += 1000;  // others of the mesh
  }
  patch.Pack();
  return patch;
}

// A press pushes the hand away from the side that it presses, or not at all.
TEST(TipContacts, ASlideBeyondThePatchDoesNotContinueOnTheOtherSideOfAThinOrgan) {
  auto patches = std::make_unique<ToolPatches>();
  ToolPatch& patch = patches->places[0];
  patch = SoftPlane(0, kTipStiffness);
  patch.Pack();
  patch.far = OtherSide();
  patch.far.mesh_triangles.fill(-1);
  TipContacts contacts;
  contacts.SetPatches(*patches);
  for (int i = 0; i < 100; ++i) Tick(&contacts, 0.025);
  ASSERT_GT(contacts.result().reaction_W.z(), 0.3);
  for (double x = 0.025; x < 0.045; x += 2e-4) {
    EXPECT_GE(Tick(&contacts, x).reaction_W.z(), 0) << x;
  }
}

}  // namespace
}  // namespace hpdm
