#include "tools/session/session_path.h"

#include <gtest/gtest.h>

#include <fstream>

#include "engine/base/error.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

TEST(SessionPath, OnlyWhatIsReallyInTheFolderIsItsFile) {
  const ScratchFolder scratch;
  const fs::path folder = scratch.path() / "session";
  fs::create_directories(folder / "below");
  std::ofstream(scratch / "secret") << "x";
  std::ofstream(folder / "file") << "x";
  fs::create_symlink("../secret", folder / "out");
  fs::create_symlink("file", folder / "in");
  fs::create_symlink("nowhere", folder / "dangling");
  EXPECT_EQ(FileInside(folder, "in").filename(), "file");
  for (const char* name : {"out", "dangling", "below", "missing", "../secret"}) {
    EXPECT_TRUE(FileInside(folder, name).empty()) << name;
  }
  EXPECT_TRUE(LeadsOutside(folder, "out"));
  for (const char* name : {"in", "file", "dangling"}) EXPECT_FALSE(LeadsOutside(folder, name));
  const fs::path here = fs::current_path();
  fs::current_path(folder);
  EXPECT_FALSE(FileInside("", "file").empty()) << "no folder is this one";
  fs::current_path(here);
}

TEST(SessionPath, AFolderStandsForItsLog) {
  const ScratchFolder folder;
  EXPECT_THROW(LogPathOf(folder.path()), InputError);
  std::ofstream(folder / kSessionLogName) << "x";
  EXPECT_EQ(LogPathOf(folder.path()), folder / kSessionLogName);
  EXPECT_EQ(LogPathOf(folder / kSessionLogName), folder / kSessionLogName);
  EXPECT_EQ(LogPathOf(folder / "missing"), folder / "missing") << "whoever opens it tells";
}

}  // namespace
}  // namespace hpdm
