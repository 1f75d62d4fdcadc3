#include "tools/session/session_folder.h"

#include <gtest/gtest.h>

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
