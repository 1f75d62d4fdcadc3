// Tests that a session's folder is a complete record.

#include <nlohmann/json.hpp>

#include "scenes/loader/file_hash.h"
#include "tests/support/program.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scratch_folder.h"
#include "tools/session/session_folder.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// FIPS 180-4's one-block example, and no bytes.
constexpr char kSumOfAbc[] = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
constexpr char kSumOfNothing[] = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

std::string Entry(const std::string& name, const std::string& sum, const std::string& copy = "") {
  return "[[file]]\nname='" + name + "'\n" + (copy.empty() ? "" : "copy='" + copy + "'\n") +
         "sha256='" + sum + "'\n";
}

TEST(FileHash, IsTheStandardsSha256) {
  const ScratchFolder folder;
  std::ofstream(folder / "abc") << "abc";
  std::ofstream(folder / "nothing");
  EXPECT_EQ(Sha256OfFile(folder / "abc"), kSumOfAbc);
  EXPECT_EQ(Sha256OfFile(folder / "nothing"), kSumOfNothing);
  EXPECT_THROW(Sha256OfFile(folder / "missing"), InputError);
}

class RecordedScene : public SceneTest {
 protected:
  void SetUp() override { folder_.Write("m.obj", "abc"); }
};

TEST_F(RecordedScene, IsVerifiedFileByFile) {
  const Scene scene = Load(kOrgan + Entry("m.obj", kSumOfAbc));
  ASSERT_EQ(scene.files.size(), 1u);
  EXPECT_TRUE(scene.recorded);
  EXPECT_EQ(scene.files[0].sha256, kSumOfAbc);
  folder_.Write("m.obj", "abd");
  const std::string error = LoadError(kOrgan + Entry("m.obj", kSumOfAbc));
  EXPECT_TRUE(StartsWith(error, "s.toml:3:6: organ[0].mesh: differs from the recorded file"));
  EXPECT_TRUE(Contains(error, "restore m.obj, or remove the [[file]] tables"));
}

TEST_F(RecordedScene, ReadsACopyInsteadOfTheNameAndNothingOutside) {
  folder_.Write("copy.obj", "abc");
  const std::string far = "[[organ]]\nname='liver'\nmesh='/far/away/liver.obj'\n";
  const Scene scene = Load(far + Entry("/far/away/liver.obj", kSumOfAbc, "copy.obj"));
  EXPECT_EQ(fs::path(scene.organs[0].mesh).filename(), "copy.obj");

  for (const char* out : {"../copy.obj", "/etc/hostname", "meshes/../../copy.obj", ".", ""}) {
    EXPECT_TRUE(
        Contains(LoadError(far + Entry("/far/away/liver.obj", kSumOfAbc, out + std::string())),
                 *out == '\0' ? "no such file" : "leads out of the scene's folder"))
        << out;
  }
  const ScratchFolder elsewhere;
  std::ofstream(elsewhere / "m.obj") << "abc";
  const std::string named = "[[organ]]\nname='liver'\nmesh='" + (elsewhere / "m.obj") + "'\n";
  EXPECT_TRUE(Contains(LoadError(named + Entry(elsewhere / "m.obj", kSumOfAbc)),
                       "lies outside the folder of a recorded scene"));
  fs::create_symlink(elsewhere / "m.obj", folder_.path() / "link.obj");
  EXPECT_TRUE(Contains(LoadError(far + Entry("/far/away/liver.obj", kSumOfAbc, "link.obj")),
                       "lies outside the folder of a recorded scene"));
}

TEST_F(RecordedScene, RefusesPathsThroughAnotherFolder) {
  // The path stays inside this folder but leaves the folder of a copy.
  const std::string around = "../" + folder_.path().filename().string() + "/m.obj";
  for (const std::string& name : {around, (folder_.path() / "m.obj").string()}) {
    const std::string organ = "[[organ]]\nname='liver'\nmesh='" + name + "'\n";
    EXPECT_TRUE(Contains(LoadError(organ + Entry(name, kSumOfAbc)),
                         "lies outside the folder of a recorded scene"))
        << name;
    EXPECT_TRUE(Load(organ + Entry(name, kSumOfAbc, "m.obj")).recorded);
  }
}

TEST_F(RecordedScene, RefusesTheNamesOfTheSessionsOwnFiles) {
  for (const char* own : {"session.lcmlog", "summary.json/m.obj", "./frames/m.obj"}) {
    fs::create_directories((folder_.path() / own).parent_path());
    folder_.Write(own, "abc");
    const Scene scene = Load(kOrgan + Entry("m.obj", kSumOfAbc, own));
    const ScratchFolder kept;
    EXPECT_TRUE(Contains(ErrorOf([&] { SessionFolder(kept / "out", scene); }),
                         "is a file that a session itself writes"))
        << own;
  }
}

TEST_F(RecordedScene, MustBeWhole) {
  EXPECT_TRUE(Contains(LoadError(kOrgan + Entry("t.png", kSumOfNothing)),
                       "organ[0].mesh: has no [[file]] table"));
  EXPECT_TRUE(
      Contains(LoadError(kOrgan + Entry("m.obj", "0123")), "file[0].sha256: is not a SHA-256"));
  EXPECT_TRUE(Contains(LoadError(kOrgan + Entry("m.obj", kSumOfAbc) + Entry("m.obj", kSumOfAbc)),
                       "file[1].name: is already used"));
}

// The tests below record real sessions; their organ is small and its mesh is a liver's.
class Record : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_.path() / "far");
    fs::create_directories(folder_.path() / "scenes/meshes");
    fs::copy_file(kScenes / "meshes/liver_274.obj", folder_ / "far/liver.obj");
    fs::copy_file(kScenes / "meshes/probe_562.obj", folder_ / "scenes/meshes/probe.obj");
    // A name that the session gives to a picture of its own.
    fs::copy_file(kScenes / "textures/liver_1332.png", folder_ / "scenes/last.png");
    scene_ =
        "# A liver from afar.\r\n[scene]\nbackground = \"last.png\"\n[[organ]]\nname = \"liver\" # "
        "comment\nmesh = \"../far/liver.obj\"\n"
        "[[instrument]]\nname = \"probe\"\ntrocar = [0.05, -0.12, 0.16]\n"
        "mesh = \"meshes/probe.obj\"\n"
        "jaws = { meshes = [\"" +
        (folder_ / "far/../scenes/meshes/probe.obj") +
        "\"], pivot = 0.0, opening_deg = 20 }  # the last line";
    std::ofstream(folder_ / "scenes/s.toml", std::ios::binary) << scene_;
  }

  const ScratchFolder folder_;
  std::string scene_;
};

TEST_F(Record, KeepsTheTextAndEveryFileInsideItsFolder) {
  const SessionFolder kept(folder_ / "out", LoadScene(folder_ / "scenes/s.toml"));
  const std::string text = ReadFile(folder_ / "out/scene.toml");
  EXPECT_TRUE(text.starts_with(scene_ + "\n\n# The files that the session read")) << text;
  std::vector<std::string> copies;
  for (const KeptFile& file : kept.files()) {
    copies.push_back(file.copy);
    EXPECT_EQ(Sha256OfFile(kept.File(file.copy)), file.sha256);
  }
  EXPECT_EQ(copies, (std::vector<std::string>{"files/last.png", "files/liver.obj",
                                              "meshes/probe.obj", "files/probe.obj"}));
}

TEST_F(Record, ARecordOfARecordHasTheSameBytes) {
  const SessionFolder first(folder_ / "a", LoadScene(folder_ / "scenes/s.toml"));
  fs::remove_all(folder_ / "scenes");
  fs::remove_all(folder_ / "far");
  fs::rename(folder_ / "a", folder_ / "moved");
  const SessionFolder second(folder_ / "b", LoadScene(folder_ / "moved/scene.toml"));
  EXPECT_EQ(ReadFile(folder_ / "moved/scene.toml"), ReadFile(folder_ / "b/scene.toml"));
  EXPECT_EQ(second.files().size(), first.files().size());
  EXPECT_TRUE(LoadScene(folder_ / "b/scene.toml").recorded);
}

TEST_F(Record, OverwritesNothing) {
  fs::create_directories(folder_.path() / "out/meshes");
  std::ofstream(folder_ / "out/meshes/probe.obj") << "mine";
  const auto record = [this] {
    SessionFolder(folder_ / "out", LoadScene(folder_ / "scenes/s.toml"));
  };
  EXPECT_TRUE(Contains(ErrorOf(record), "out/meshes/probe.obj: already exists and differs from"));
  EXPECT_EQ(ReadFile(folder_ / "out/meshes/probe.obj"), "mine");
  fs::remove(folder_ / "out/meshes/probe.obj");
  std::ofstream(folder_ / "out/scene.toml") << "mine";
  EXPECT_TRUE(Contains(ErrorOf(record), "out/scene.toml: already exists and is another scene"));
  EXPECT_EQ(ReadFile(folder_ / "out/scene.toml"), "mine");
}

TEST_F(Record, ReplaysAfterItsSceneIsGoneAndItselfHasMoved) {
  const std::string trace = folder_ / "far/motion.csv";
  {
    std::ofstream motion(trace);
    motion << "t,px,py,pz\n";
    for (int i = 0; i <= 50; ++i) motion << 0.01 * i << ",0," << -0.001 * i << ",0\n";
  }
  const std::string command =
      kHpdmProgram + " run " + (folder_ / "scenes/s.toml") +
      " --clock lockstep --seconds 0.5 --no-pictures --device trace:" + trace + " --out " +
      (folder_ / "out") + " >" + (folder_ / "o") + " 2>&1";
  ASSERT_EQ(Shell(command), 0) << ReadFile(folder_ / "o");
  const Json summary = Json::parse(ReadFile(folder_ / "out/summary.json"));
  const Json& files = summary["files"];
  ASSERT_EQ(files.size(), 5u);
  EXPECT_EQ(files[4]["name"], trace);
  EXPECT_EQ(files[4]["sha256"], Sha256OfFile(trace));
  const std::string kept_trace = files[4]["copy"];
  const Json& arguments = summary["command"]["arguments"];
  EXPECT_EQ(arguments[1], "run");
  EXPECT_NE(std::find(arguments.begin(), arguments.end(), "trace:" + trace), arguments.end());

  fs::rename(folder_ / "out", folder_ / "moved");
  fs::remove_all(folder_ / "scenes");
  fs::remove_all(folder_ / "far");
  EXPECT_EQ(Shell(kHpdmProgram + " replay --tolerance 0 " + (folder_ / "moved") + " >" +
                  (folder_ / "o") + " 2>&1"),
            0)
      << ReadFile(folder_ / "o");

  // Runs the session again from the record alone and expects the same log bit for bit.
  ASSERT_EQ(Shell(kHpdmProgram + " run " + (folder_ / "moved/scene.toml") +
                  " --clock lockstep --seconds 0.5 --no-pictures --device trace:" +
                  (folder_ / "moved/" + kept_trace) + " --out " + (folder_ / "again") + " >" +
                  (folder_ / "o") + " 2>&1"),
            0)
      << ReadFile(folder_ / "o");
  EXPECT_TRUE(ReadFile(folder_ / "again/session.lcmlog") ==
              ReadFile(folder_ / "moved/session.lcmlog"));
  EXPECT_EQ(ReadFile(folder_ / "again/scene.toml"), ReadFile(folder_ / "moved/scene.toml"));

  std::ofstream(folder_ / "moved/files/liver.obj", std::ios::app) << "# touched\n";
  const auto expect_refused = [this](const std::string& why) {
    EXPECT_EQ(
        Shell(kHpdmProgram + " replay " + (folder_ / "moved") + " >/dev/null 2>" + (folder_ / "o")),
        2);
    EXPECT_TRUE(Contains(ReadFile(folder_ / "o"), why));
    EXPECT_EQ(Count(ReadFile(folder_ / "o"), "\n"), 1);
  };
  expect_refused("differs from the recorded file");

  // A foreign folder that leads to files of this machine.
  const fs::path moved = folder_.path() / "moved", liver = kScenes / "meshes/liver_274.obj";
  fs::create_symlink(liver, moved / "link.obj");
  std::ofstream(moved / "scene.toml") << "[[organ]]\nname = \"liver\"\nmesh = \"link.obj\"\n";
  expect_refused("is outside the session folder");
  fs::rename(moved / "scene.toml", folder_.path() / "elsewhere.toml");
  fs::create_symlink("../elsewhere.toml", moved / "scene.toml");
  expect_refused("is a link out of the session folder");
}

}  // namespace
}  // namespace hpdm
