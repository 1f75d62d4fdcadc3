#include "tools/run/film.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "render/image/frame_sink.h"
#include "tests/support/scratch_folder.h"
#include "tools/shared/child_process.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

bool HaveFfmpeg() {
  try {
    return RunChild({"ffmpeg", "-version"}) == 0;
  } catch (const std::exception&) {
    return false;
  }
}

class Film : public testing::Test {
 protected:
  void WriteFrames(int count) {
    FrameSink sink(frames_, 10);
    Image image{.width = 33, .height = 21, .rgb = std::vector<std::uint8_t>(3 * 33 * 21, 128)};
    for (int i = 0; i < count; ++i) sink.Add(image, i * 100'000'000);
    ASSERT_EQ(sink.written(), count);
  }

  const ScratchFolder folder_;
  const fs::path frames_ = folder_.path() / "50%d" / "frames", film_ = folder_.path() / "film.mp4";
};

TEST_F(Film, FramesOfOddSidesBecomeAnMp4) {
  if (!HaveFfmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  WriteFrames(5);
  EXPECT_EQ(MakeFilm(frames_, 10, film_), "");
  std::ifstream file(film_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_GT(bytes.size(), 100u);
  EXPECT_EQ(bytes.substr(4, 4), "ftyp");  // ISO base media
  EXPECT_NE(bytes.find("avc1"), std::string::npos);
}

TEST_F(Film, AnErrorOfFfmpegIsReportedAndLeavesNoFilm) {
  if (!HaveFfmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  fs::create_directories(frames_);
  const std::string reported = MakeFilm(frames_, 10, film_);
  EXPECT_NE(reported.find("ffmpeg exited with"), std::string::npos) << reported;
  EXPECT_NE(reported.find(frames_.string()), std::string::npos) << reported;
  EXPECT_FALSE(fs::exists(film_));
}

TEST_F(Film, WithoutFfmpegTheRemedyIsNamed) {
  const char* path = std::getenv("PATH");
  const std::string kept = path == nullptr ? "" : path;
  setenv("PATH", folder_.path().c_str(), 1);
  const std::string reported = MakeFilm(frames_, 10, film_);
  setenv("PATH", kept.c_str(), 1);
  EXPECT_NE(reported.find("install the package ffmpeg"), std::string::npos) << reported;
}

}  // namespace
}  // namespace hpdm
