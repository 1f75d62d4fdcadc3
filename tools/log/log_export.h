#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// One channel as it was exported.
struct ExportedChannel {
  std::string channel;
  std::string type;            ///< As MessageSchemas::TypeOf has it.
  std::filesystem::path file;  ///< Empty: left out, since no message is of a known type.
  std::uint64_t messages = 0;  ///< Written.
  std::uint64_t skipped = 0;   ///< Not readable.
};

/// Writes each channel of a log as a table CHANNEL.csv in `folder` (made when missing): a row a
/// message, the log's time stamp (us) first, then a column a value, named as in MessageValue. Where
/// arrays change their length the columns are those of the longest, and missing cells are empty.
/// Numbers are written so that they read back exactly, with a decimal point in every locale.
/// `channels` empty: all. Channels of unknown types are left out; channel names become file names
/// without a path's characters, of at most 200 bytes and a number where they would be alike. All
/// tables appear when all are whole, or none. Throws InputError where a file cannot be used or a
/// channel that was asked for is missing.
std::vector<ExportedChannel> ExportCsv(const std::string& log, const std::filesystem::path& folder,
                                       const std::vector<std::string>& channels,
                                       const MessageSchemas& schemas);

/// Throws the InputError of a channel that was asked for and is not in the log.
[[noreturn]] void RefuseMissingChannel(const std::string& log, const std::string& channel);

}  // namespace hpdm
