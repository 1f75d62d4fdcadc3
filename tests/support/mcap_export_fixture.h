#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/liver_scene.h"
#include "tests/support/mcap_reader.h"
#include "tests/support/read_file.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/log/mcap_export.h"

namespace hpdm {

inline void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline const std::string kMcapScene = kMetricLiver + kRearSupport + kPalpatingProbe;

/// Exports logs that the tests write in a folder of their own.
class McapExportTest : public testing::Test {
 protected:
  template <typename Message>
  void Append(SessionLog* log, const char* channel, std::int64_t time_us, const Message& message) {
    log->Append(channel, time_us, EncodeMessage(message, &buffer_));
  }
  std::vector<ExportedChannel> Export(const std::vector<std::string>& channels = {}) {
    return ExportMcap(log_, file_, channels, MessageSchemas::Hpdm());
  }
  McapFile File() const { return McapFile(ReadFile(file_)); }
  void RecordSession(int ticks) {
    WriteBytes(folder_ / "scene.toml", kMcapScene);
    Record({.scene = folder_ / "scene.toml", .log = log_, .ticks = ticks});
  }
  void WriteEvents(int count) {
    SessionLog log(log_, 0);
    for (int i = 0; i < count; ++i) {
      event_t event{};
      event.sequence = i + 1;
      event.time_ns = 1000 * i;
      event.name = "n" + std::to_string(i);
      Append(&log, kEventChannel, i, event);
    }
  }
  std::size_t FilesInFolder() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(folder_.path()),
                      std::filesystem::directory_iterator()));
  }

  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
  const std::string file_ = folder_ / "session.mcap";
  std::vector<std::uint8_t> buffer_;
};

}  // namespace hpdm
