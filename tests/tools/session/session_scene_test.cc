#include "tools/session/session_scene.h"

#include <gtest/gtest.h>

#include "scenes/loader/scene.h"
#include "tools/session/session_model.h"

namespace hpdm {
namespace {

/// Four organs: the first and the last touch the second, so that three can push each other.
Scene FourOrgans() {
  Scene scene;
  for (const char* name : {"liver", "stomach", "spleen", "gallbladder"}) {
    scene.organs.emplace_back().name = name;
  }
  scene.organs[1].contacts = {{.with = "liver", .friction = 0}};
  scene.organs[3].contacts = {{.with = "stomach", .friction = 0}};
  return scene;
}

TEST(LimitsOf, JoinOrgansThatPushEachOtherThroughOthers) {
  const SessionLimits limits = LimitsOf(FourOrgans());
  EXPECT_EQ(limits.pushing, (std::vector<std::size_t>{0, 0, 2, 0}));
  EXPECT_TRUE(limits.still);
  for (const std::optional<double>& settles : limits.settles) EXPECT_EQ(settles, 0.0);
}

TEST(LimitsOf, ABreathingOrganKeepsItsOwnRestButNotThatOfThoseItPushes) {
  Scene scene = FourOrgans();
  scene.organs[2].motion = {.displacement_W = Vector3d(0, 0, 0.01), .frequency = 0.25};
  SessionLimits limits = LimitsOf(scene);
  EXPECT_FALSE(limits.still);
  for (const std::optional<double>& settles : limits.settles) EXPECT_EQ(settles, 0.0);

  scene.organs[0].motion = scene.organs[2].motion;
  limits = LimitsOf(scene);
  for (const int pushed : {0, 1, 3}) EXPECT_FALSE(limits.settles[pushed]) << pushed;
  EXPECT_EQ(limits.settles[2], 0.0);
}

TEST(LimitsOf, AFreeOrganMayLieAnywhere) {
  Scene scene = FourOrgans();
  scene.organs[2].free = FreeOptions();
  const SessionLimits limits = LimitsOf(scene);
  EXPECT_TRUE(limits.still) << "its energy is in the log";
  EXPECT_FALSE(limits.settles[2]);
  EXPECT_EQ(limits.settles[0], 0.0);
}

TEST(NamesOfASession, KnowHooksAndScissorsThatFreeLayers) {
  const Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/gallbladder_removal.toml");
  const StatusNames names = SessionModel(scene).Names();
  EXPECT_EQ(names.frees_layers,
            (std::vector<std::vector<bool>>{{false}, {true, false, true, false, false}}))
      << "grasper; hook, clip applier, scissors, right grasper, suction";
}

// The status text tells by them how far a duct is from the jaws, and where it lies between them.
TEST(NamesOfASession, HaveTheLengthOfJawsThatCloseOnDucts) {
  const Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/clip_and_cut.toml");
  const StatusNames names = SessionModel(scene).Names();
  ASSERT_EQ(names.duct_jaws.size(), scene.instruments.size());
  int closing = 0;
  for (std::size_t t = 0; t < scene.instruments.size(); ++t) {
    for (int held = 0; held < scene.instruments[t].HeldCount(); ++held) {
      const InstrumentDescription& instrument = scene.instruments[t].Held(held);
      const bool closes = instrument.type == InstrumentType::kClipApplier ||
                          instrument.type == InstrumentType::kScissors;
      closing += closes;
      EXPECT_EQ(names.duct_jaws[t][ToSize(held)], closes ? instrument.geometry.JawsLength() : 0)
          << instrument.name;
    }
  }
  EXPECT_GE(closing, 2);
}

}  // namespace
}  // namespace hpdm
