#include "tools/log/mcap_writer.h"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>

#include "engine/base/error.h"
#include "tests/support/mcap_export_fixture.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

TEST_F(McapExportTest, ChunksEndBehindTheMessageThatFillsThem) {
  WriteEvents(30'000);
  Export();
  const McapFile file = File();
  EXPECT_EQ(file.messages.size(), 30'000u);
  EXPECT_GT(file.chunks, 2u);
  EXPECT_GE(file.most_chunk_bytes, McapWriter::kChunkBytes);
  EXPECT_LT(file.most_chunk_bytes, McapWriter::kChunkBytes + 200) << "one message more";

  {
    SessionLog log(log_, 0);
    organ_t organ{};
    organ.value_count = 500'000;  // longer than a chunk
    organ.displacements.assign(500'000, 0.25f);
    for (int i = 0; i < 3; ++i) Append(&log, kOrganChannel, 3 - i, organ);  // time goes backwards
  }
  Export();
  EXPECT_EQ(File().chunks, 3u);
}

TEST_F(McapExportTest, AnEmptyLogIsAnEmptyFile) {
  WriteBytes(log_, "");
  EXPECT_TRUE(Export().empty());
  const McapFile file = File();
  EXPECT_EQ(file.messages.size() + file.chunks + file.metadata.size(), 0u);
}

TEST_F(McapExportTest, AFailedExportLeavesTheOlderFile) {
  WriteEvents(5000);
  EXPECT_THROW(ExportMcap(log_, log_, {}, MessageSchemas::Hpdm()), InputError);
  EXPECT_THROW(Export({"NONE"}), InputError);
  EXPECT_THROW(ExportMcap(log_, folder_.path(), {}, MessageSchemas::Hpdm()), InputError);
  EXPECT_THROW(ExportMcap(log_, "/proc/a.mcap", {}, MessageSchemas::Hpdm()), InputError);
  if (access("/dev/full", W_OK) == 0) {
    EXPECT_THROW(ExportMcap(log_, "/dev/full", {}, MessageSchemas::Hpdm()), InputError);
    EXPECT_TRUE(fs::is_character_file("/dev/full"));
  }
  EXPECT_EQ(FilesInFolder(), 1u) << "the log";

  // A disk that fills up on the way.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small = {10'000, before.rlim_max};
  WriteBytes(file_, "an older export");
  fs::create_directory(folder_.path() / "csv");
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string reported;
  try {
    Export();
  } catch (const InputError& error) {
    reported = error.what();
  }
  EXPECT_THROW(ExportCsv(log_, folder_.path() / "csv", {}, MessageSchemas::Hpdm()), InputError);
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(reported.find("session.mcap: cannot be written (File too large)"), std::string::npos)
      << reported;
  EXPECT_EQ(ReadFile(file_), "an older export");
  EXPECT_EQ(FilesInFolder(), 3u);
  EXPECT_TRUE(fs::is_empty(folder_.path() / "csv"));
  Export();
  EXPECT_EQ(File().messages.size(), 5000u);
}

TEST_F(McapExportTest, LinksAndPipesKeepTheirPlace) {
  WriteEvents(50);
  Export();
  const std::string expected = ReadFile(file_);
  WriteBytes(folder_ / "elsewhere.mcap", "old");
  fs::create_symlink("elsewhere.mcap", folder_ / "link.mcap");
  ExportMcap(log_, folder_ / "link.mcap", {}, MessageSchemas::Hpdm());
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.mcap"));
  EXPECT_EQ(ReadFile(folder_ / "elsewhere.mcap"), expected);

  std::FILE* pipe = popen(("cat > " + (folder_ / "piped.mcap")).c_str(), "w");
  ASSERT_NE(pipe, nullptr);
  ExportMcap(log_, "/proc/self/fd/" + std::to_string(fileno(pipe)), {}, MessageSchemas::Hpdm());
  EXPECT_EQ(pclose(pipe), 0);
  EXPECT_EQ(ReadFile(folder_ / "piped.mcap"), expected);
}

TEST_F(McapExportTest, TheReaderOfTheseTestsMissesNoFlippedByte) {
  WriteEvents(20);
  Export();
  const std::string sound = ReadFile(file_);
  for (std::size_t i = 0; i < sound.size(); ++i) {
    std::string flipped = sound;
    flipped[i] ^= 1;
    EXPECT_THROW(McapFile{flipped}, std::runtime_error) << i;
  }
}

}  // namespace
}  // namespace hpdm
