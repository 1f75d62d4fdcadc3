#include "scenes/loader/changed_files.h"

#include "scenes/loader/file_hash.h"
#include "tests/support/scene_fixture.h"

namespace hpdm {
namespace {

using FileNames = std::vector<std::string>;

class ChangedFilesTest : public SceneTest {
 protected:
  std::filesystem::path Record(const std::string& name, const std::string& sum,
                               const std::string& copy = "") const {
    return folder_.Write("s.toml", "[[file]]\nname='" + name + "'\n" +
                                       (copy.empty() ? "" : "copy='" + copy + "'\n") + "sha256='" +
                                       sum + "'\n");
  }
};

TEST_F(ChangedFilesTest, AreThoseWithOtherContents) {
  const std::string sum = Sha256OfFile(folder_.Write("m.obj", "abc"));
  EXPECT_EQ(ChangedFiles(Record("m.obj", sum)), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("/far/away.obj", sum, "m.obj")), FileNames{});
  folder_.Write("m.obj", "abd");
  EXPECT_EQ(ChangedFiles(Record("m.obj", sum)), FileNames{"m.obj"});
  EXPECT_EQ(ChangedFiles(Record("/far/away.obj", sum, "m.obj")), FileNames{"m.obj"});
}

TEST_F(ChangedFilesTest, AreNoneWithoutARecordAndNoneOutside) {
  const std::string none(64, '0');
  EXPECT_EQ(ChangedFiles(""), FileNames{});
  EXPECT_EQ(ChangedFiles(folder_.path() / "missing.toml"), FileNames{});
  EXPECT_EQ(ChangedFiles(folder_.Write("s.toml", "file = [7]")), FileNames{});
  EXPECT_EQ(ChangedFiles(folder_.Write("s.toml", "file = 7")), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("m.obj", "short")), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("missing.obj", none)), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("meshes", none)), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("/etc/hostname", none)), FileNames{});
  EXPECT_EQ(ChangedFiles(Record("../m.obj", none)), FileNames{});
}

}  // namespace
}  // namespace hpdm
