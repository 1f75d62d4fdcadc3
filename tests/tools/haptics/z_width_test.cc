#include "tools/haptics/z_width.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "haptics/safety/stability.h"
#include "tools/haptics/shipped_contacts.h"
#include "tools/haptics/transparency.h"

namespace hpdm {
namespace {

std::filesystem::path TwoHandsScene() {
  return std::filesystem::path(HPDM_SOURCE_DIR) / "scenes" / "two_hands.toml";
}

// A probe and a grasper on the liver.
const std::vector<ShippedContact>& Contacts() {
  static const std::vector<ShippedContact> contacts =
      FindContacts(ContactSession(TwoHandsScene(), 0, -1));
  return contacts;
}

TEST(ShippedContacts, AProbePressesAndAGrasperHoldsTheLiver) {
  ASSERT_EQ(Contacts().size(), 2u);
  EXPECT_EQ(Contacts()[0].name, "two_hands: probe on liver");
  EXPECT_EQ(Contacts()[1].name, "two_hands: grasper on liver");
  EXPECT_FALSE(Contacts()[0].grasps);
  EXPECT_TRUE(Contacts()[1].grasps);
}

// The stiffer scene has a higher modulus and stiffer supports. Its patches are solved anew.
TEST(ShippedContacts, StiffenedPatchesHaveTheForcesOfStifferTissue) {
  constexpr double kStiffer = 3;
  Scene scene = LoadScene(TwoHandsScene());
  for (OrganOptions& organ : scene.organs) organ.material.young *= kStiffer;
  for (const ShippedContact& stiff : FindContacts(std::make_shared<const Session>(scene))) {
    const ShippedContact& soft = Contacts()[stiff.grasps ? 1 : 0];
    const ToolPatches stiffened = Stiffened(soft.patches, soft.session->organs(), kStiffer);
    for (const double x : {0.001, 0.003, 0.005, 0.006}) {
      const double expected = StaticForce(stiff, stiff.patches, x);
      EXPECT_NEAR(StaticForce(soft, stiffened, x), expected, 1e-3 * std::abs(expected))
          << stiff.name << ", " << x;
    }
  }
}

// The closed form knows neither the tick nor the contact.
TEST(ZWidth, WithoutFrictionAndControllerTheBoundaryIsThatOfTheExactRoots) {
  for (const ShippedContact& contact : Contacts()) {
    for (const auto& [period, delay] : {std::pair(1e-3, 0.0), {1e-3, 2e-3}, {4e-3, 0.0}}) {
      const DisplayConditions ideal{
          .period = period, .delay = delay, .control = false, .guard = false, .ideal = true};
      const ZWidthPoint point = MeasureZWidthPoint(contact, ideal, false, true, 1);
      // The search ends at 1 %.
      EXPECT_NEAR(point.measured, point.exact, 0.02 * point.exact) << contact.name;
      // A linear loop beyond Colgate's bound may be stable, below it must be.
      EXPECT_GT(point.measured, point.passivity) << contact.name;
    }
  }
}

TEST(ZWidth, DelayAndSlowTicksNarrowItAndTheShippedContactHasAMarginOfTwo) {
  const ShippedContact& contact = Contacts()[0];
  const auto width = [&](const DisplayConditions& display) {
    return MeasureZWidthPoint(contact, display, false, false, 0.5).measured;
  };
  const double shipped = width({});
  EXPECT_GT(shipped, 2 * contact.stiffness);
  EXPECT_LT(width({.delay = 5e-3}), 0.5 * shipped);
  EXPECT_LT(width({.period = 4e-3}), 0.5 * shipped);
}

TEST(ZWidth, ATooStiffContactAndAWrongLinearLoopAreMissed) {
  const auto missed = [](double shipped, double linear) {
    ZWidthPoint point;
    point.contact = "scene: probe on organ";
    point.sweep = "loop";
    point.shipped = shipped;
    point.measured = 1000;
    point.exact = 900;
    std::vector<ZWidthPoint> points(4, point);
    points[1].display.control = false;
    points[2].display.guard = false;
    points[3].display = {.control = false, .guard = false, .ideal = true};
    points[3].measured = linear;
    return ZWidthTables(points)[0].Missed();
  };
  EXPECT_EQ(missed(499, 900), 0);
  EXPECT_EQ(missed(501, 900), 1);
  EXPECT_EQ(missed(499, 850), 1);
  EXPECT_EQ(missed(499, 950), 1);
}

TEST(Transparency, APressIsTransparentAndADelayTurnsItsPhaseByItsOwnAngle) {
  const ShippedContact& contact = Contacts()[0];
  constexpr double kHertz = 10, kDelay = 0.005;
  const std::vector<Transparency> both =
      MeasureTransparency(contact, {{}, {.delay = kDelay}}, {1, kHertz});
  const Transparency &now = both[0], &late = both[1];
  EXPECT_NEAR(now.points[0].ratio, 1, 0.1);
  EXPECT_NEAR(now.points[0].phase, 0, 10);
  EXPECT_NEAR(late.points[1].phase - now.points[1].phase, -360 * kHertz * kDelay, 2);
}

// A tip with friction slips in a first press and sticks to and fro. The model does as the hand.
TEST(Transparency, APressWithFrictionIsTransparentToo) {
  Scene scene = LoadScene(TwoHandsScene().replace_filename("abdomen_on_springs.toml"));
  scene.organs.resize(1);  // the liver
  scene.organs[0].contacts.clear();
  scene.instruments.erase(scene.instruments.begin());
  const std::vector<ShippedContact> contacts = FindContacts(std::make_shared<const Session>(scene));
  ASSERT_EQ(contacts.size(), 1u);
  const Transparency measured = MeasureTransparency(contacts[0], {{}}, {2})[0];
  EXPECT_NEAR(measured.points[0].ratio, 1, 0.02);
}

Transparency Response(double ratio, double phase) {
  return {"scene: probe on organ",
          {},
          50,
          {{1, 1e-3, 50 * ratio, ratio, phase}, {20, 1e-3, 50, 0.2, -90}}};
}

TEST(Transparency, ASoftOrLateForceIsMissedBelowTwoHertzOnly) {
  const auto missed = [](double ratio, double phase) {
    int count = 0;
    for (const ContactTable& table : TransparencyTables({Response(ratio, phase)})) {
      count += table.Missed();
    }
    return count;
  };
  EXPECT_EQ(missed(1.05, -5), 0);
  EXPECT_EQ(missed(0.85, -5), 1);
  EXPECT_EQ(missed(1.15, -15), 2);
}

}  // namespace
}  // namespace hpdm
