#include "tools/shared/staged_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

void Save(const fs::path& path, std::string_view text) {
  StagedFile file(path);
  file.Write(text);
  file.Commit();
}

TEST(StagedFile, AnOpenFileIsContinuedNotReplaced) {
  const ScratchFolder folder;
  const std::string path = folder / "all.txt";
  std::ofstream(path) << "before,";
  const int open_file = open(path.c_str(), O_WRONLY | O_APPEND);
  const std::string name = "/dev/fd/" + std::to_string(open_file);  // as /dev/stdout
  fs::create_symlink(name, folder / "link");
  Save(name, "one,");
  Save(folder / "link", "two,");
  ASSERT_EQ(write(open_file, "after", 5), 5) << "it is the same file still";
  close(open_file);
  EXPECT_EQ(ReadFile(path), "before,one,two,after");
}

TEST(StagedFile, ALinkKeepsItsPlaceAndWhatItLeadsToIsReplaced) {
  const ScratchFolder folder;
  std::ofstream(folder / "file") << "a long text before";
  fs::create_symlink("file", folder / "link");
  Save(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(ReadFile(folder / "file"), "new");
  { StagedFile("never").Write("x"); }
  EXPECT_FALSE(fs::exists("never"));
}

}  // namespace
}  // namespace hpdm
