#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Result of the export of one channel.
struct ExportedChannel {
  std::string channel;
  std::string type;            ///< As MessageSchemas::TypeOf returns it.
  std::filesystem::path file;  ///< Empty: left out, because no message is of a known type.
  std::uint64_t messages = 0;  ///< Messages written.
  std::uint64_t skipped = 0;   ///< Unreadable messages.
};

/// Writes each channel of a log as a table CHANNEL.csv in `folder`, which is created if missing.
///
///   - A row per message: the log's time stamp (us), then one column per value, named as in
///     MessageValue. If arrays change their length the columns are those of the longest, and
///     missing cells are empty.
///   - Numbers read back exactly and have a decimal point in every locale.
///   - `channels` empty: all. Channels of unknown types are left out.
///   - File names are channel names without the characters of a path, at most 200 bytes, with a
///     number if two were equal.
///   - Either all tables appear, complete, or none.
///
/// Throws InputError if a file cannot be used or a requested channel is missing. `at_event` is
/// called for each event of the log and may throw to end the export.
std::vector<ExportedChannel> ExportCsv(
    const std::string& log, const std::filesystem::path& folder,
    const std::vector<std::string>& channels, const MessageSchemas& schemas,
    const std::function<void()>& at_event = [] {});

/// Throws the InputError for a requested channel that is not in the log.
[[noreturn]] void RefuseMissingChannel(const std::string& log, const std::string& channel);

}  // namespace hpdm
