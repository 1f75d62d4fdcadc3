// Tests of a session for programs: copies, assignments and resets continue to the last bit.

#include "tools/session/lockstep_session.h"

#include <algorithm>

#include "scenes/loader/scene.h"

namespace hpdm {
namespace {

// Two simulated hands, which touch the liver within a second.
LockstepSession SimulatedSession() {
  static const auto model =
      std::make_shared<const SessionModel>(LoadScene(HPDM_SOURCE_DIR "/scenes/two_hands.toml"));
  return {model, std::vector<DeviceChoice>(2, {DeviceChoice::Type::kSim, {}})};
}

std::vector<double> ForcesOf(LockstepSession* session, int steps) {
  std::vector<double> forces;
  for (int i = 0; i < steps; ++i) {
    session->Step();
    forces.insert(forces.end(), session->tick_forces().begin(), session->tick_forces().end());
  }
  return forces;
}

bool Touches(const std::vector<double>& forces) {
  return std::any_of(forces.begin(), forces.end(), [](double force) { return force != 0; });
}

TEST(LockstepSession, CopiesContinueApartFromTheOriginal) {
  LockstepSession session = SimulatedSession();
  ForcesOf(&session, 20);
  LockstepSession copy = session;
  const std::vector<double> forces = ForcesOf(&session, 15);
  EXPECT_TRUE(Touches(forces));
  EXPECT_EQ(ForcesOf(&copy, 15), forces);
  EXPECT_EQ(ForcesOf(&copy, 15), ForcesOf(&session, 15));
}

TEST(LockstepSession, AnAssignmentReturnsToTheStateAndKeepsTheArrays) {
  LockstepSession session = SimulatedSession();
  ForcesOf(&session, 20);
  const LockstepSession state = session;
  const double* vertices = session.organ(0).vertices.data();
  const ToolView* tools = session.tools().data();
  const std::vector<double> forces = ForcesOf(&session, 15);
  session = state;
  EXPECT_EQ(session.organ(0).vertices, state.organ(0).vertices);
  EXPECT_EQ(ForcesOf(&session, 15), forces);
  EXPECT_EQ(session.organ(0).vertices.data(), vertices);
  EXPECT_EQ(session.tools().data(), tools);
}

TEST(LockstepSession, AResetIsANewSession) {
  LockstepSession session = SimulatedSession();
  const std::vector<double> forces = ForcesOf(&session, 45);
  EXPECT_TRUE(Touches(forces));
  session.Reset();
  EXPECT_EQ(session.steps(), 0u);
  EXPECT_EQ(ForcesOf(&session, 45), forces);
}

TEST(LockstepSession, AnotherStiffnessIsThatOfASceneWithIt) {
  LockstepSession session = SimulatedSession();
  const std::vector<double> soft = ForcesOf(&session, 45);
  session.SetYoung(0, 7000);
  EXPECT_FALSE(session.model().IsOfSceneFile());
  Scene scene = LoadScene(HPDM_SOURCE_DIR "/scenes/two_hands.toml");
  scene.organs[0].material.young = 7000;
  LockstepSession other(std::make_shared<const SessionModel>(std::move(scene)), session.devices());
  const std::vector<double> stiff = ForcesOf(&session, 45);
  EXPECT_EQ(ForcesOf(&other, 45), stiff);
  EXPECT_NE(stiff, soft);
}

}  // namespace
}  // namespace hpdm
