// Ctrl-C during `hpdm log export`, as a user presses it.

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/program.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

std::size_t Files(const fs::path& folder) {
  std::error_code ignored;
  fs::directory_iterator files(folder, ignored);
  return static_cast<std::size_t>(std::distance(files, fs::directory_iterator()));
}

/// Writes a log whose export takes seconds.
void WriteLongLog(const std::string& path) {
  tool_t tool{};
  tool.tool_count = 1;
  tool.tools.resize(1);
  std::vector<std::uint8_t> buffer;
  SessionLog log(path, 0);
  for (int tick = 0; tick < 150'000; ++tick) {
    tool.sequence = tool.tick = tick;
    log.Write("HPDM_TOOL", tick * 1'000'000LL, EncodeMessage(tool, &buffer));
  }
}

TEST(InterruptedExport, LeavesNoFileOfEitherFormat) {
  std::signal(SIGINT, SIG_DFL);  // a test in a script's background would ignore it
  const ScratchFolder folder;
  const std::string log = folder / "session.lcmlog";
  WriteLongLog(log);
  for (const std::string format : {"csv", "mcap"}) {
    SCOPED_TRACE(format);
    const fs::path out = folder.path() / format;
    fs::create_directory(out);
    const std::string to = format == "csv" ? out.string() : (out / "session.mcap").string();
    BackgroundCommand program(
        "exec " + kHpdmProgram + " log export " + log + " --format " + format + " --out " + to,
        folder / "stdout", folder / "stderr");
    ASSERT_TRUE(Becomes([&] { return Files(out) > 0; })) << program.err();
    program.Signal(SIGINT);
    EXPECT_EQ(program.Wait(), 130) << program.out() << program.err();
    EXPECT_EQ(program.err(), "hpdm: interrupted: nothing was exported\n");
    EXPECT_EQ(Files(out), 0u);
  }
}

}  // namespace
}  // namespace hpdm
