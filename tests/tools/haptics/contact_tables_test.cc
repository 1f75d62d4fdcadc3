#include "tools/haptics/contact_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tools/haptics/bonded_disc.h"
#include "tools/haptics/edge_grasp.h"

namespace hpdm {
namespace {

constexpr double kBallRadius = 0.005;

std::vector<BallPress> PressesOf(const WideBlock& block) {
  return PressBall(block, kBallRadius, {0.1 * kBallRadius, kBallRadius});
}

bool IsMissed(const RatioRange& range) {
  return JudgedValue{range.low, 0.95, 1.05}.Missed() ||
         JudgedValue{range.high, 0.95, 1.05}.Missed();
}

// A flat punch of the ball's radius, a wrong modulus, and Hertz's law where it no longer holds.
TEST(ContactTables, AWrongLawIsMissedAndTheRightOneIsNot) {
  const WideBlock block{.squares = 16};
  MaterialOptions material = block.Options().material;
  const std::vector<BallPress> presses = PressesOf(block);
  const auto missed = [&](double (*law)(double, double, const MaterialOptions&), double share) {
    const double depth = share * kBallRadius;
    return IsMissed(ForceOverLaw(
        presses, [&](double d) { return law(d, kBallRadius, material); }, depth, depth));
  };
  EXPECT_FALSE(missed(SneddonForce, 0.1));
  EXPECT_FALSE(missed(SneddonForce, 1));
  EXPECT_FALSE(missed(HertzForce, 0.1));
  EXPECT_TRUE(missed(HertzForce, 1));
  EXPECT_TRUE(missed(
      [](double d, double r, const MaterialOptions& m) {
        return 2 * m.young / (1 - m.poisson * m.poisson) * r * d;
      },
      1));
  material.young *= 1.1;
  EXPECT_TRUE(missed(SneddonForce, 0.1));
  EXPECT_TRUE(missed(SneddonForce, 1));
}

TEST(ContactTables, OnePressOutOfRangeIsEnough) {
  const auto law = [](double depth) { return depth; };
  std::vector<BallPress> presses = {{1, 1, 1, 1}, {2, 2, 2, 2}};
  EXPECT_FALSE(IsMissed(ForceOverLaw(presses, law, 0, 2)));
  presses[1].settled_tick = 1.8;
  EXPECT_TRUE(IsMissed(ForceOverLaw(presses, law, 0, 2)));
  presses[1].settled_tick = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(IsMissed(ForceOverLaw(presses, law, 0, 2)));
  presses.push_back({3, 3, 3, 3});  // does not hide the NaN before it
  EXPECT_TRUE(IsMissed(ForceOverLaw(presses, law, 0, 3)));
  EXPECT_TRUE(IsMissed(ForceOverLaw({}, law, 0, 2)));
}

// The half-space of another Poisson's ratio has another stiffness for each motion.
TEST(ContactTables, ADiscHasTheStiffnessOfItsOwnMaterialOnly) {
  const DiscStiffness measured = MeasureDisc({.poisson = 0.3});
  const DiscStiffness exact = ExactDiscStiffness(0.3), other = ExactDiscStiffness(0.0);
  const auto missed = [](double ratio) { return JudgedValue{ratio, 0.9, 1.1}.Missed(); };
  EXPECT_FALSE(missed(measured.normal / exact.normal));
  EXPECT_FALSE(missed(measured.tangential / exact.tangential));
  EXPECT_FALSE(missed(measured.rocking / exact.rocking));
  EXPECT_FALSE(missed(measured.twist / exact.twist));
  EXPECT_TRUE(missed(measured.twist / other.twist));
  EXPECT_TRUE(missed(measured.twist / measured.rocking));
}

// Between the jaws a coarse lattice bends and twists too little. A finer one comes nearer.
TEST(ContactTables, AGraspThatTurnsIsTooStiffAndLessSoOnAFinerLattice) {
  const GraspTurns exact = ExactGraspTurns();
  const GraspTurns coarse = TurnGrasp(0.003, 4, 27), fine = TurnGrasp(0.003, 8, 64);
  for (const auto turn : {&GraspTurns::in_faces, &GraspTurns::about_edge, &GraspTurns::twist}) {
    EXPECT_GT(fine.*turn, exact.*turn);
    EXPECT_LT(fine.*turn, 1.6 * exact.*turn);
    EXPECT_LT(fine.*turn, coarse.*turn);
    EXPECT_LT(coarse.*turn, 2.4 * exact.*turn);
  }
}

TEST(ContactTables, MissedValuesAreMarkedAndCounted) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const ContactTable table{
      "name",
      "Title.",
      "Target.",
      {{"good", "good_N"}, {"bad", "bad_N"}},
      {{"first", {{1, 0, 2}, {3, 0, 2}}}, {"second", {{2, 0, 2}, {none, 0, 2}}}}};
  EXPECT_EQ(table.Missed(), 2);
  EXPECT_EQ(TableMarkdown(table),
            "Title. Target.\n\n| | good | bad |\n|---|---|---|\n| first | 1.000 | **3.000** |\n"
            "| second | 2.000 | **nan** |\n");
  EXPECT_NE(TableText(table).find("3.000*"), std::string::npos);
  const auto json = TablesJson({table});
  EXPECT_EQ(json[0]["missed"], 2);
  EXPECT_EQ(json[0]["rows"][0]["good_N"], 1);
  EXPECT_EQ(json[0]["rows"][0]["missed"], nlohmann::ordered_json({"bad_N"}));
  EXPECT_TRUE(json[0]["rows"][1]["bad_N"].is_null());
}

}  // namespace
}  // namespace hpdm
