#include "scenes/loader/scene_names.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

using Names = std::vector<std::vector<std::string>>;

Names NamesIn(const std::string& text) {
  const ScratchFolder folder;
  std::ofstream(folder / "scene.toml") << text;
  return SceneInstruments(folder / "scene.toml");
}

// Neither the missing meshes nor a key that this version refuses matters.
TEST(SceneInstruments, AreInTheOrderOfTheirIndices) {
  EXPECT_EQ(NamesIn(R"(
[[organ]]
name = "liver"
mesh = "missing.obj"
[organ.material]
relaxation_time = 1  # refused

[[instrument]]
name = "probe"
[[instrument.exchange]]
name = "hook"
[[instrument.exchange]]
name = "blunt"

[[instrument]]
name = "grasper"
)"),
            (Names{{"probe", "hook", "blunt"}, {"grasper"}}));
}

TEST(SceneInstruments, AreNoneWithoutAScene) {
  EXPECT_EQ(SceneInstruments(""), Names{});
  EXPECT_EQ(SceneInstruments("/nonexistent/scene.toml"), Names{});
  EXPECT_EQ(NamesIn(""), Names{});
  EXPECT_EQ(NamesIn("instrument = "), Names{});
  EXPECT_EQ(NamesIn("instrument = 7"), Names{});
  EXPECT_EQ(NamesIn("instrument = [7]"), (Names{{""}}));
}

TEST(SceneAttachments, AreInTheOrderOfTheScene) {
  const ScratchFolder folder;
  std::ofstream(folder / "scene.toml") << R"(
[[attachment]]
a = "gallbladder"
b = "liver"
young = -1  # refused
[[attachment]]
b = "stomach"
)";
  EXPECT_EQ(SceneAttachments(folder / "scene.toml"),
            (std::vector<std::string>{"gallbladder and liver", "? and stomach"}));
  EXPECT_TRUE(SceneAttachments("").empty());
  EXPECT_TRUE(SceneAttachments("/nonexistent/scene.toml").empty());
}

}  // namespace
}  // namespace hpdm
