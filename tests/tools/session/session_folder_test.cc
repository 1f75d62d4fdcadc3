#include "tools/session/session_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>

#include "engine/base/error.h"
#include "tests/support/scratch_folder.h"
#include "tools/session/session_path.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

void Write(const fs::path& path) { std::ofstream(path) << "x"; }

TEST(SessionFolder, ADiscardedFolderIsGoneIfTheSessionMadeIt) {
  const ScratchFolder scratch;
  SessionFolder folder(scratch.path() / "s", Scene());
  Write(folder.File(kSessionLogName));
  folder.Discard();
  EXPECT_FALSE(fs::exists(scratch.path() / "s"));
}

TEST(SessionFolder, ADiscardedFolderOfOthersKeepsTheirFiles) {
  const ScratchFolder scratch;
  Write(scratch.path() / "notes.txt");
  SessionFolder folder(scratch.path(), Scene());
  Write(folder.File(kSessionLogName));
  folder.Discard();
  EXPECT_TRUE(fs::exists(scratch.path() / "notes.txt"));
  EXPECT_FALSE(fs::exists(scratch.path() / kSessionLogName));
}

TEST(SessionFolder, APathThroughAFileIsRefusedBeforeTheSetUp) {
  const ScratchFolder scratch;
  Write(scratch.path() / "f");
  for (const char* out : {"f", "f/", "f/s"}) {
    EXPECT_THROW(SessionFolder::RefuseExisting(scratch.path() / out), InputError) << out;
  }
}

// A write to a file that may not grow fails, as on a full disk.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit small{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
  }
  ~SmallFiles() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(SessionFolder, ACopyThatFailsNamesTheFileLeavesNothingAndCanBeTriedAgain) {
  const ScratchFolder scratch;
  std::ofstream(scratch.path() / "large.obj") << std::string(300'000, 'x');
  Scene scene;
  scene.files.push_back({"meshes/large.obj", scratch / "large.obj", "", ""});
  fs::create_directory(scratch.path() / "mine");
  Write(scratch.path() / "mine/notes.txt");
  for (const char* out : {"new", "mine"}) {
    try {
      const SmallFiles limit(150'000);
      SessionFolder(scratch.path() / out, scene);
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      const std::string expected = std::string(out) + "/meshes/large.obj: cannot be written (File";
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
    EXPECT_FALSE(fs::exists(scratch.path() / out / "meshes"));
    const SessionFolder again(scratch.path() / out, scene);
    EXPECT_EQ(fs::file_size(again.File("meshes/large.obj")), 300'000u);
  }
  EXPECT_FALSE(fs::exists(scratch.path() / "new/notes.txt"));
  EXPECT_TRUE(fs::exists(scratch.path() / "mine/notes.txt"));
}

TEST(SessionFolder, AFolderWithASessionIsRefusedWithTheWayToANewOne) {
  const ScratchFolder scratch;
  EXPECT_NO_THROW(SessionFolder::RefuseExisting(scratch.path()));
  EXPECT_NO_THROW(SessionFolder::RefuseExisting(scratch.path() / "none"));
  Write(scratch.path() / kSessionLogName);
  try {
    SessionFolder::RefuseExisting(scratch.path());
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("leave --out out to get a new folder"),
              std::string::npos)
        << error.what();
  }
}

TEST(SessionFolder, AFileThatASessionWouldReplaceIsKept) {
  const ScratchFolder scratch;
  Write(scratch.path() / "summary.json");
  EXPECT_THROW(SessionFolder::RefuseExisting(scratch.path()), InputError);
  EXPECT_THROW(SessionFolder(scratch.path(), Scene()), InputError);
  EXPECT_TRUE(fs::exists(scratch.path() / "summary.json"));
  EXPECT_FALSE(fs::exists(scratch.path() / "scene.toml"));
}

}  // namespace
}  // namespace hpdm
