// Compares pictures of the scenes with the recorded ones (tests/golden/README.md).

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "render/image/image_file.h"
#include "tests/support/picture_difference.h"
#include "tests/support/scratch_folder.h"
#include "tools/shared/child_process.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

// The mean bound is half of a just noticeable difference. No visible part (1 % of the picture is 36
// x 21 pixels) may differ by more than a change of shade.
constexpr double kMean = 1.0, kP99 = 6.0;

Image Plain(std::uint8_t value) {
  return {.width = 64, .height = 48, .rgb = std::vector<std::uint8_t>(3 * 64 * 48, value)};
}

TEST(PictureDifference, EqualPicturesDoNotDifferAndBlackIsAHundredFromWhite) {
  EXPECT_EQ(Compare(Plain(90), Plain(90)).mean, 0);
  // White's rounded coordinates are within 0.02 of 100.
  EXPECT_NEAR(Compare(Plain(0), Plain(255)).mean, 100, 0.05);
  EXPECT_NEAR(Compare(Plain(0), Plain(255)).p99, 100, 0.05);
}

TEST(PictureDifference, APixelMoreOnAnEdgeIsToleratedAndAThingThatMovedIsNot) {
  Image edge = Plain(60), edge_later = Plain(60), moved = Plain(60);
  for (int y = 10; y < 30; ++y) {
    for (int x = 10; x < 30; ++x) {
      for (int c = 0; c < 3; ++c) {
        const auto set = [&](Image* image, int at_x) {
          image->rgb[static_cast<std::size_t>(3 * (y * image->width + at_x) + c)] = 90;
        };
        set(&edge, x);
        set(&moved, x + 15);
        set(&edge_later, x);
        if (x == 29 && y % 2 == 0) set(&edge_later, 30);
      }
    }
  }
  const PictureDifference sampled = Compare(edge, edge_later), other = Compare(edge, moved);
  EXPECT_LT(sampled.mean, kMean);
  EXPECT_LT(sampled.p99, kP99);
  EXPECT_GT(other.p99, kP99);
}

struct Case {
  const char* name;
  const char* scene;
  const char* seconds;
  std::vector<std::string> options = {};
};

void PrintTo(const Case& picture, std::ostream* out) { *out << picture.name; }

class Picture : public testing::TestWithParam<Case> {};

TEST_P(Picture, LooksAsItDid) {
  const ScratchFolder folder;
  const std::string scene = std::string(HPDM_SOURCE_DIR) + "/scenes/" + GetParam().scene + ".toml";
  std::vector<std::string> words = {std::string(HPDM_BINARY_DIR) + "/tools/hpdm",
                                    "run",
                                    scene,
                                    "--clock",
                                    "lockstep",
                                    "--seconds",
                                    GetParam().seconds,
                                    "--size",
                                    "320x240",
                                    "--fps",
                                    "0",
                                    "--out",
                                    folder / "session"};
  words.insert(words.end(), GetParam().options.begin(), GetParam().options.end());
  ASSERT_EQ(RunChild(words), 0);
  const fs::path drawn = folder.path() / "session" / "last.png";
  const fs::path stored =
      fs::path(HPDM_SOURCE_DIR) / "tests/golden/pictures" / (std::string(GetParam().name) + ".png");
  if (std::getenv("HPDM_WRITE_GOLDENS") != nullptr) {
    fs::create_directories(stored.parent_path());
    fs::copy_file(drawn, stored, fs::copy_options::overwrite_existing);
  }
  const PictureDifference difference = Compare(ReadPng(drawn), ReadPng(stored));
  const bool same = difference.mean < kMean && difference.p99 < kP99;
  if (!same) {
    const fs::path kept = fs::temp_directory_path() / (std::string(GetParam().name) + "_drawn.png");
    fs::copy_file(drawn, kept, fs::copy_options::overwrite_existing);
    ADD_FAILURE() << "mean " << difference.mean << ", p99 " << difference.p99 << ": compare "
                  << kept << " with " << stored;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Picture,
    testing::Values(Case{"palpation", "liver_palpation", "1.6"},
                    Case{"two_hands", "two_hands", "2"}, Case{"abdomen", "abdomen", "2.5"},
                    Case{"overlays", "two_hands", "2", {"--overlay", "force,contacts,lattice"}},
                    Case{"exchanged", "two_hands", "1", {"--exchange", "probe=hook@0.05"}}),
    [](const auto& picture) { return std::string(picture.param.name); });

}  // namespace
}  // namespace hpdm
