// Replayed sessions in pictures: where they are seen from, and the film.

#include "tools/replay/replay_view.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "engine/base/error.h"
#include "tests/support/flow_fixture.h"
#include "tools/session/picture_options.h"
#include "tools/session/session_scene.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

/// Keeps the last picture.
class LastPicture : public PictureViewer {
 public:
  LastPicture(const ReplayViewOptions& options, Session* session)
      : PictureViewer(ParseView(options.view, *session),
                      RenderOptionsOf(options.size, options.overlays, *session), nullptr,
                      HeadlessContext, session) {}
  bool OnStep(Nanoseconds /*time_ns*/) override {
    Draw();
    return true;
  }
  const Image& image() const { return render_.image(); }
};

class ReplayViewTest : public Flow {
 protected:
  void Record() {
    const Outcome outcome =
        Hpdm("run " + kScene + " --clock lockstep --seconds 1 --fps 0 --size 160x120 --out " +
             Folder("session"));
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  Image Replayed(const std::string& view) const {
    Session session(LoadRecordedScene(folder_ / "session/scene.toml"));
    LastPicture viewer({.view = view, .size = "160x120", .overlays = {}}, &session);
    const LogReplay replay =
        ReplayLog(LoggedSession(folder_ / "session/session.lcmlog"), 0, &session, &viewer);
    EXPECT_FALSE(replay.comparison.first().has_value()) << "a viewer changes no bit";
    return viewer.image();
  }
  bool LeavesNothing() const {
    for (const auto& entry : fs::directory_iterator(folder_)) {
      if (entry.path().string().find(".part") != std::string::npos) return false;
    }
    return true;
  }
};

TEST_F(ReplayViewTest, TheLaparoscopesPictureIsTheSessionsPixelForPixel) {
  SKIP_WITHOUT_EGL();
  Record();
  const Image last = ReadPng(folder_ / "session/last.png");
  ASSERT_EQ(last.width, 160);
  EXPECT_EQ(Replayed("laparoscope").rgb, last.rgb);
  EXPECT_NE(Replayed("above").rgb, last.rgb);
}

TEST(ParseView, LooksAlongTheNamedAxisAtTheOrgans) {
  const Session session(LoadScene(kScenes / "liver_palpation.toml"));
  const Points& liver = session.organs()[0].rest().vertices;
  for (const auto& [name, from] :
       {std::pair{"front", Vector3d(0, -1, 0)}, std::pair{"behind", Vector3d(0, 1, 0)},
        std::pair{"left", Vector3d(-1, 0, 0)}, std::pair{"right", Vector3d(1, 0, 0)},
        std::pair{"below", Vector3d(0, 0, -1)}, std::pair{"above", Vector3d(0, 0, 1)}}) {
    const LaparoscopeOptions camera = ParseView(name, session);
    EXPECT_LT(((camera.p_scope_W - camera.p_target_W).normalized() - from).norm(), 1e-12) << name;
    const Laparoscope scope(camera, 400, 400);
    for (int v = 0; v < liver.rows(); ++v) {
      const Vector3d at = scope.Project(liver.row(v));
      ASSERT_LT((at.head<2>() - Eigen::Vector2d(200, 200)).norm(), scope.circle_radius_px())
          << name;
    }
  }
}

TEST(ParseView, TakesAPositionAndATarget) {
  const Session session(LoadScene(kScenes / "liver_palpation.toml"));
  const LaparoscopeOptions camera = ParseView("-0.1,0.2,3e-1,0,0,.05", session);
  EXPECT_EQ(camera.p_scope_W, Vector3d(-0.1, 0.2, 0.3));
  EXPECT_EQ(camera.p_target_W, Vector3d(0, 0, 0.05));
  EXPECT_EQ(ParseView("laparoscope", session).p_scope_W, session.scene().laparoscope.p_scope_W);
  for (const char* wrong : {"", "Above", "1,2,3", "1,2,3,4,5,6,7", "1,2,3,4,5,", "1,2,3,4,5,x",
                            "nan,0,0,0,0,0", "1,1,1,1,1,1"}) {
    EXPECT_THROW(ParseView(wrong, session), InputError) << wrong;
  }
}

TEST_F(ReplayViewTest, AFilmHasTheSessionsLengthAndLeavesNoFrames) {
  SKIP_WITHOUT_EGL();
  if (Shell("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "install the package ffmpeg";
  Record();
  const Outcome outcome = Hpdm("replay " + Folder("session") + " --film " + Folder("film.mp4") +
                               " --view above --size 200x150 --overlay text,force");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("the same bit for bit"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("film: " + Folder("film.mp4")), std::string::npos) << outcome.out;
  EXPECT_TRUE(LeavesNothing());
  const std::string facts = Folder("facts");
  ASSERT_EQ(Shell("ffprobe -v error -count_frames -show_entries "
                  "stream=width,height,nb_read_frames -of csv=p=0 " +
                  Folder("film.mp4") + " >" + facts),
            0);
  EXPECT_EQ(ReadFile(facts), "200,150,29\n") << "steps 0.000 to 0.933 s at 30 Hz";
}

TEST_F(ReplayViewTest, AFilmThatCannotBeMadeIsRefusedBeforeTheReplay) {
  for (const auto& [arguments, fault] :
       {std::pair<std::string, std::string>{"--film film.avi", "ends with .mp4"},
        {"--film " + Folder("absent/film.mp4"), "cannot be written"},
        {"--view above", "need --film FILE or --window"},
        {"--film a.mp4 --clock real", "need --clock logged"},
        {"--film a.mp4 --size 3x3", "is out of range"},
        {"--film a.mp4 --window", "--window"}}) {
    const Outcome outcome = Hpdm("replay " + Folder("missing") + " " + arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_NE(outcome.err.find(fault), std::string::npos) << outcome.err;
    EXPECT_EQ(Count(outcome.err, "\n"), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace hpdm
