#include <fstream>
#include <numbers>

#include "scenes/loader/scene_names.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

const std::string kOrgans = kOrgan + R"(
[[organ]]
name = 'bag'
mesh = 'm.obj'
[[organ]]
name = 'fat'
mesh = 'm.obj'
[[attachment]]
a = 'fat'
b = 'liver'
sphere = { centre = [0, 0, 0], radius = 1 }
young = 1
thickness = 0.001
strength = 1
toughness = 1
[[attachment]]
a = 'bag'
b = 'liver'
sphere = { centre = [1, 0, 0], radius = 1 }
young = 1
thickness = 0.002
strength = 1
toughness = 1
[[instrument]]
name = 'grasper'
type = 'grasper'
trocar = [0, 0, 1]
[[instrument]]
name = 'probe'
trocar = [0, 1, 1]
[[instrument.exchange]]
name = 'hook'
type = 'hook'
power = 55
)";

const std::string kStep = "[[exercise.step]]\nname='first'\nforce=1\n";

TEST_F(SceneTest, AnExerciseHasTheValuesOfItsKeys) {
  const Scene scene = Load(kOrgans + R"(
[exercise]
name = 'bed'
goal = 'Free it.'
time_limit = 200
target_time = 80
[[exercise.step]]
name = 'take'
instruction = 'Take the bag'
hold = 'bag'
hold_with = 'grasper'
lift = 0.01
time = 0.5
[[exercise.step]]
name = 'touch'
touch = 'liver'
touch_with = 'hook'
at = [1, 2, 3]
within = 0.02
force = 0.7
[[exercise.step]]
name = 'free'
free = 'liver'
from = 'bag'
area = 9e-4
[[exercise.step]]
name = 'leave'
release = 'bag'
[[exercise.error]]
kind = 'tear'
name = 'torn'
organ = 'bag'
limit = 3e-5
points = 7
[[exercise.error]]
kind = 'burn'
organ = 'liver'
[[exercise.error]]
kind = 'near_burn'
path = [[1, 0, 0], [2, 0, 0]]
within = 0.005
[[exercise.error]]
kind = 'drop'
path = [[0, 1, 0], [0, 2, 0]]
within = 0.02
)");
  ASSERT_TRUE(scene.exercise.has_value());
  const ExerciseOptions& exercise = *scene.exercise;
  EXPECT_EQ(exercise.name, "bed");
  EXPECT_EQ(exercise.goal, "Free it.");
  EXPECT_EQ(exercise.time_limit, 200);
  EXPECT_EQ(exercise.target_time, 80);
  ASSERT_EQ(exercise.steps.size(), 4u);
  const ExerciseStepOptions& take = exercise.steps[0];
  EXPECT_EQ(take.instruction, "Take the bag");
  EXPECT_EQ(take.holds.value().organ, 1);
  ASSERT_EQ(take.holds->with.size(), 1u);
  EXPECT_EQ(take.holds->with[0].hand, 0);
  EXPECT_EQ(take.holds->with[0].instrument_index, 0);
  EXPECT_EQ(take.lift, 0.01);
  EXPECT_EQ(take.time, 0.5);
  EXPECT_FALSE(take.touches || !take.frees.empty() || take.releases || take.force);
  const ExerciseStepOptions& touch = exercise.steps[1];
  EXPECT_EQ(touch.instruction, "touch") << "its name";
  EXPECT_EQ(touch.touches.value().organ, 0);
  EXPECT_EQ(touch.touches->with.at(0).hand, 1);
  EXPECT_EQ(touch.touches->with.at(0).instrument_index, 1);
  EXPECT_EQ(touch.at_W.value(), Vector3d(1, 2, 3));
  EXPECT_EQ(touch.within, 0.02);
  EXPECT_EQ(touch.force, 0.7);
  EXPECT_EQ(exercise.steps[2].frees, std::vector{1}) << "the bag's, not the fat's";
  EXPECT_EQ(exercise.steps[2].freed_area, 9e-4);
  EXPECT_EQ(exercise.steps[3].releases, 1);
  ASSERT_EQ(exercise.errors.size(), 4u);
  EXPECT_EQ(exercise.errors[0].kind, ExerciseErrorKind::kTear);
  EXPECT_EQ(exercise.errors[0].name, "torn");
  EXPECT_EQ(exercise.errors[0].attachment, 1);
  EXPECT_EQ(exercise.errors[0].limit, 3e-5);
  EXPECT_EQ(exercise.errors[0].points, 7);
  EXPECT_EQ(exercise.errors[1].organ, 0);
  EXPECT_EQ(exercise.errors[1].limit, 0.3);
  EXPECT_EQ(exercise.errors[2].path_W,
            (std::vector<Vector3d>{Vector3d(1, 0, 0), Vector3d(2, 0, 0)}));
  EXPECT_EQ(exercise.errors[2].within, 0.005);
  EXPECT_EQ(exercise.errors[2].limit, 0.1) << "s";
  EXPECT_EQ(exercise.errors[3].path_W.size(), 2u);
  EXPECT_EQ(exercise.errors[3].within, 0.02);
  ASSERT_EQ(exercise.hooks.size(), 1u);
  EXPECT_EQ(exercise.hooks[0].hand, 1);
  EXPECT_EQ(exercise.hooks[0].instrument_index, 1);
  EXPECT_EQ(scene.instruments[1].Held(1).geometry.power, 55);
  EXPECT_EQ(scene.attachments[1].burn_energy, 1.9e9 * 0.002);
}

TEST_F(SceneTest, AnExerciseOfDucts) {
  const auto duct = [](const std::string& name, const std::string& label, const std::string& ends) {
    return "[[duct]]\nname = '" + name + "'\nlabel = '" + label + "'\n" + ends +
           "path = [[0, 0, 0], [0, 0, 1]]\nradius = 0.01\nwall = 0.001\nyoung = 1\n";
  };
  const Scene scene = Load(kOrgans + duct("first", "goes", "a = 'bag'\nb = 'liver'\n") +
                           duct("second", "goes", "a = 'liver'\nb = 'bag'\n") +
                           duct("third", "stays", "a = 'liver'\n") + R"(
[exercise]
removes = 'bag'
[[exercise.step]]
name = 'clip'
clip = 'goes'
clips = 4
[[exercise.step]]
name = 'cut'
cut = 'second'
[[exercise.step]]
name = 'take'
hold = 'bag'
at = [1, 2, 3]
within = 0.02
[[exercise.error]]
kind = 'bad_clip'
limit = 30
[[exercise.error]]
kind = 'bad_clip'
duct = 'third'
[[exercise.error]]
kind = 'wrong_clip'
duct = 'goes'
organ = 'liver'
[[exercise.error]]
kind = 'early_cut'
before = 'cut'
[[exercise.error]]
kind = 'early_clip'
before = 'clip'
duct = 'first'
[[exercise.error]]
kind = 'dropped_clip'
[[exercise.error]]
kind = 'cut_outside_clips'
[[exercise.error]]
kind = 'stretch'
duct = 'third'
limit = 1.2
[[exercise.error]]
kind = 'near_burn'
duct = 'goes'
within = 0.001
[[exercise.error]]
kind = 'wrong_cut'
organ = 'liver'
)");
  const ExerciseOptions& exercise = scene.exercise.value();
  ASSERT_EQ(exercise.ducts.size(), 3u);
  EXPECT_EQ(exercise.ducts[0].name, "first");
  EXPECT_EQ(exercise.ducts[0].organ_end, 0);
  EXPECT_EQ(exercise.ducts[1].organ_end, 1);
  EXPECT_EQ(exercise.ducts[2].organ_end, -1);
  EXPECT_EQ(exercise.steps[0].clips, (std::vector<int>{0, 1})) << "by their label";
  EXPECT_EQ(exercise.steps[0].clip_count, 4);
  EXPECT_EQ(exercise.steps[1].clip_count, 3);
  EXPECT_EQ(exercise.steps[1].cuts, std::vector<int>{1}) << "by its name";
  EXPECT_EQ(exercise.steps[2].at_W.value(), Vector3d(1, 2, 3));
  const auto& errors = exercise.errors;
  EXPECT_DOUBLE_EQ(errors[0].limit, std::numbers::pi / 6);
  EXPECT_TRUE(errors[0].ducts.empty());
  EXPECT_DOUBLE_EQ(errors[1].limit, std::numbers::pi / 9);
  EXPECT_EQ(errors[1].ducts, std::vector<int>{2});
  EXPECT_EQ(errors[2].ducts, (std::vector<int>{0, 1}));
  EXPECT_EQ(errors[2].organ, 0);
  EXPECT_EQ(errors[3].before, 1);
  EXPECT_EQ(errors[4].before, 0);
  EXPECT_EQ(errors[4].kind, ExerciseErrorKind::kEarlyClip);
  EXPECT_EQ(errors[5].kind, ExerciseErrorKind::kLostClip);
  EXPECT_EQ(errors[6].kind, ExerciseErrorKind::kBadCut);
  EXPECT_EQ(errors[7].kind, ExerciseErrorKind::kStretch);
  EXPECT_EQ(errors[7].limit, 1.2);
  EXPECT_EQ(errors[8].ducts, (std::vector<int>{0, 1}));
  EXPECT_TRUE(errors[8].path_W.empty());
  EXPECT_EQ(errors[8].within, 0.001);
  EXPECT_EQ(errors[9].kind, ExerciseErrorKind::kWrongCut);
  EXPECT_EQ(errors[9].organ, 0);
}

const std::string kFreesTheBed = R"(
[exercise]
[[exercise.step]]
name = 'free'
free = 'bed'
area = 1e-4
)";

TEST_F(SceneTest, AStepNamesAnAttachment) {
  std::string organs = kOrgans;
  const std::string second = "[[attachment]]\na = 'bag'";
  organs.replace(organs.find(second), second.size(), "[[attachment]]\nname = 'bed'\na = 'bag'");
  const Scene scene = Load(organs + kFreesTheBed + R"(
[[exercise.error]]
kind = 'tear'
organ = 'bed'
)");
  EXPECT_EQ(scene.attachments[1].name, "bed");
  EXPECT_EQ(scene.exercise.value().steps[0].frees, std::vector{1});
  EXPECT_EQ(scene.exercise->errors[0].attachment, 1);
}

TEST_F(SceneTest, AStepFreesAllAttachmentsOfALabel) {
  std::string organs = kOrgans;
  for (std::size_t at = 0; (at = organs.find("[[attachment]]\n", at)) != std::string::npos;
       at += 15) {
    organs.insert(at + 15, "label = 'bed'\n");
  }
  const Scene scene = Load(organs + kFreesTheBed);
  ASSERT_EQ(scene.attachments.size(), 2u);
  EXPECT_EQ(scene.exercise.value().steps[0].frees, (std::vector{0, 1}));
}

TEST_F(SceneTest, AnExerciseTakesTheScenesNameAndHalfOfItsTime) {
  const Scene scene = Load(kOrgans + "[scene]\nname='s'\n[exercise]\ntime_limit=60\n" + kStep);
  EXPECT_EQ(scene.exercise.value().name, "s");
  EXPECT_EQ(scene.exercise->target_time, 30);
  EXPECT_FALSE(Load(kOrgans).exercise.has_value());
}

// A report reads the exercise of a scene whose meshes are gone.
TEST(SceneExercise, NeedsNoMeshes) {
  const ScratchFolder folder;
  std::ofstream(folder / "scene.toml") << kOrgans << "[exercise]\n" << kStep;
  const auto exercise = SceneExercise(folder / "scene.toml");
  ASSERT_TRUE(exercise.has_value());
  EXPECT_EQ(exercise->steps[0].name, "first");
  EXPECT_FALSE(SceneExercise(folder / "missing.toml").has_value());
  EXPECT_FALSE(SceneExercise("").has_value());
}

}  // namespace
}  // namespace hpdm
