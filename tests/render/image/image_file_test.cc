#include "render/image/image_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "engine/base/error.h"

namespace hpdm {
namespace {

std::filesystem::path TestFile(const char* name) {
  return std::filesystem::path(testing::TempDir()) / (std::string("hpdm_image_") + name);
}

/// Odd sides, so that any padding of rows shows.
Image Noise(int width, int height) {
  Image image{width, height, {}};
  std::mt19937 random(7);
  for (int i = 0; i < 3 * width * height; ++i) {
    image.rgb.push_back(static_cast<std::uint8_t>(random()));
  }
  return image;
}

template <typename Function>
std::string InputErrorOf(Function function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST(ImageFile, PngKeepsEveryByte) {
  const Image image = Noise(37, 23);
  const auto file = TestFile("round_trip.png");
  WritePng(file, image);
  const Image read = ReadPng(file);
  EXPECT_EQ(read.width, 37);
  EXPECT_EQ(read.height, 23);
  EXPECT_EQ(read.rgb, image.rgb);
}

TEST(ImageFile, EffortMakesASmoothPictureSmallerAndKeepsEveryByte) {
  Image smooth{160, 120, {}};
  for (int i = 0; i < 160 * 120; ++i) {
    const int x = i % 160, y = i / 160;
    for (const int value : {x + y, x * y / 100, 255 - x}) {
      smooth.rgb.push_back(static_cast<std::uint8_t>(value % 256));
    }
  }
  const auto fast = TestFile("fast.png"), small = TestFile("small.png");
  WritePng(fast, smooth);
  WritePng(small, smooth, PngEffort::kSmall);
  EXPECT_LT(std::filesystem::file_size(small), std::filesystem::file_size(fast));
  EXPECT_EQ(ReadPng(small).rgb, smooth.rgb);
}

TEST(ImageFile, TheSamePictureGivesTheSameFile) {
  std::vector<std::uint8_t> first, second;
  EncodePng(Noise(64, 48), &first);
  EncodePng(Noise(64, 48), &second);
  EXPECT_EQ(first, second);
}

TEST(ImageFile, AWriteThatFailsNamesTheFileAndTheReason) {
  const std::string message =
      InputErrorOf([] { WritePng("/nonexistent-folder/picture.png", Noise(4, 4)); });
  EXPECT_NE(message.find("/nonexistent-folder/picture.png"), std::string::npos) << message;
  EXPECT_NE(message.find("No such file"), std::string::npos) << message;
}

TEST(ImageFile, AFullDiskIsNoticed) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  const std::string message = InputErrorOf([] { WritePng("/dev/full", Noise(64, 64)); });
  EXPECT_NE(message.find("No space left"), std::string::npos) << message;
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full")) << "a device is not removed";
}

TEST(ImageFile, AReadThatFailsNamesTheFile) {
  const auto missing = TestFile("missing.png");
  EXPECT_NE(InputErrorOf([&] { ReadPng(missing); }).find(missing.string()), std::string::npos);

  const auto text = TestFile("text.png");
  std::ofstream(text) << "no picture";
  EXPECT_NE(InputErrorOf([&] { ReadPng(text); }).find(text.string()), std::string::npos);

  std::vector<std::uint8_t> bytes;
  EncodePng(Noise(64, 48), &bytes);
  bytes.resize(bytes.size() / 2);
  const auto cut = TestFile("cut.png");
  std::string failure;
  ASSERT_TRUE(WriteBytes(cut, bytes, &failure)) << failure;
  EXPECT_NE(InputErrorOf([&] { ReadPng(cut); }).find(cut.string()), std::string::npos);
}

}  // namespace
}  // namespace hpdm
