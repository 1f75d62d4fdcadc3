// A scripted surgeon clips and cuts the duct of scenes/clip_and_cut.toml on coarse lattices. Each error has a
// near miss beside it.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"
#include "tests/support/removal_surgeon.h"
#include "tools/session/lockstep_session.h"

namespace hpdm {
namespace {

using FoundErrors = std::vector<std::string>;
constexpr auto kCystic = RemovalSurgeon::kCysticDuct;
const char* const kBadClipOfTask = "clip oblique, loose, or too near to a clip or the bile duct";
enum { kApplier, kCuttingScissors };  // of the right hand

Scene CoarseClipAndCut() {
  Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/clip_and_cut.toml");
  for (OrganOptions& organ : scene.organs) {
    organ.lattice.cells = {4, organ.name == "liver" ? 4 : 7, 4};
    organ.lattice.local.functions = 0;
  }
  return scene;
}

class ClipAndCut : public testing::Test {
 protected:
  static LockstepSession MakeSession() {
    static const auto model = std::make_shared<const SessionModel>(CoarseClipAndCut());
    DeviceChoice command;
    command.type = DeviceChoice::Type::kCommand;
    return LockstepSession(model, {command, command});
  }
  void SetUp() override { surgeon_.Exchange(kApplier); }
  double length() const { return surgeon_.RodOf(kCystic).rest_length(); }
  double InBody() const { return length() - 0.007; }
  double AtOrgan() const { return length() - 0.0135; }
  void Clip(double arc, double turned = 0) { surgeon_.CloseOn(kCystic, arc, turned, 0.004); }
  void Cut(double arc) {
    surgeon_.Exchange(kCuttingScissors);
    surgeon_.CloseOn(kCystic, arc, 0, 0.004);
  }

  LockstepSession session_ = MakeSession();
  RemovalSurgeon surgeon_{&session_, 0};
};

TEST_F(ClipAndCut, TwoClipsAndACutBetweenThemPass) {
  Clip(InBody());
  EXPECT_EQ(surgeon_.done(), 0u);
  Clip(AtOrgan());
  EXPECT_EQ(surgeon_.done(), 1u);
  Cut((InBody() + AtOrgan()) / 2);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{});
  EXPECT_TRUE(surgeon_.result().passed);
  EXPECT_EQ(surgeon_.result().score, 100) << "before the target time";
}

TEST_F(ClipAndCut, ACutThatIsNotBetweenTheClipsDoesNotPass) {
  Clip(InBody());
  Clip(AtOrgan());
  Cut(AtOrgan() - 0.003);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{"cut outside the clips"});
  EXPECT_FALSE(surgeon_.result().passed);
}

TEST_F(ClipAndCut, ACutAfterOneClipIsEarly) {
  Clip(InBody());
  Cut((InBody() + AtOrgan()) / 2);
  EXPECT_EQ(surgeon_.Errors(), (FoundErrors{"cut before both clips", "cut outside the clips"}));
}

TEST_F(ClipAndCut, AClipTurnedTooFarIsBad) {
  constexpr double kDegreeOfTurn = std::numbers::pi / 180;
  // The way of the shaft tilts the jaws, too: cos(angle) = cos(tilt) cos(turn).
  const auto clip = [&](double arc, double degrees) {
    const double tilt = surgeon_.BestAngle(kCystic, arc);
    Clip(arc, std::acos(std::min(1.0, std::cos(degrees * kDegreeOfTurn) / std::cos(tilt))));
  };
  clip(AtOrgan(), 19);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{}) << "a near miss";
  clip(InBody(), 21);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{kBadClipOfTask});
}

TEST_F(ClipAndCut, ClipsTooNearToEachOtherAreBad) {
  Clip(InBody());
  Clip(InBody() - 0.0034);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{}) << "a near miss";
  Clip(InBody() - 0.0034 - 0.0025);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{kBadClipOfTask});
}

TEST_F(ClipAndCut, AClipBesideTheDuctIsLost) {
  surgeon_.CloseOn(kCystic, AtOrgan(), 0, -0.003);
  EXPECT_EQ(surgeon_.Errors(), FoundErrors{"clip lost"});
}

}  // namespace
}  // namespace hpdm
