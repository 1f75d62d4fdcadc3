#include "scenes/generator/picture_assets.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/base/error.h"
#include "render/image/image_file.h"
#include "scenes/generator/texturing/abdomen_picture.h"

namespace hpdm {
namespace {

std::filesystem::path CommittedPicture(const std::string& name) {
  return std::filesystem::path(HPDM_SOURCE_DIR) / "scenes/textures" / name;
}

TEST(PictureAssets, ATextureIsReproducedPixelForPixel) {
  const Image made = MakePictureAsset("gallbladder.png"),
              kept = ReadPng(CommittedPicture("gallbladder.png"));
  EXPECT_EQ(made.width, kept.width);
  EXPECT_EQ(made.height, kept.height);
  EXPECT_TRUE(made.rgb == kept.rgb)
      << "run hpdm generate --pictures --out scenes/textures and look at the change";
}

TEST(PictureAssets, TheAbdomenIsTheSameViewAtAnySize) {
  const Image small = AbdomenPicture(64, 48), kept = ReadPng(CommittedPicture("abdomen.png"));
  const int factor = kept.width / small.width;
  double sum = 0;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int k = 0; k < 3; ++k) {
        double mean = 0;
        for (int j = 0; j < factor; ++j) {
          for (int i = 0; i < factor; ++i) mean += kept.At(factor * x + i, factor * y + j)[k];
        }
        sum += std::abs(mean / (factor * factor) - small.At(x, y)[k]);
      }
    }
  }
  // A pixel of the small one is a single ray, of the kept one a mean over its texture: they differ
  // by about the texture's contrast, 8 of 255.
  EXPECT_LT(sum / (3 * small.width * small.height), 8);
}

TEST(PictureAssets, FilesStaySmall) {
  double all = 0;
  for (const PictureAsset& asset : PictureAssets()) {
    if (!asset.committed) continue;
    ASSERT_TRUE(std::filesystem::exists(CommittedPicture(asset.name))) << asset.name;
    const auto bytes =
        static_cast<double>(std::filesystem::file_size(CommittedPicture(asset.name)));
    EXPECT_LT(bytes, 400e3) << asset.name;
    all += bytes;
  }
  EXPECT_LT(all, 1.5e6);
}

TEST(PictureAssets, AnUnknownNameIsRefusedWithTheKnownOnes) {
  try {
    MakePictureAsset("spleen.png");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("liver_1332.png"), std::string::npos);
  }
}

}  // namespace
}  // namespace hpdm
