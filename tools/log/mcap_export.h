#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"
#include "tools/log/log_export.h"

namespace hpdm {

/// Writes a log as one MCAP file, which Foxglove and PlotJuggler open: every message as JSON
/// (message_json.h) on a topic of its channel's name, with a JSON schema of its type.
///
///     log_time       the log's time stamp
///     publish_time   the member `time_ns` if the type has one (the clock of the session or of a
///                    driver), else log_time
///     sequence       the low 32 bits of the member `sequence`, else the message's number on the
///                    channel, from 1
///     metadata       "hpdm.session": instruments, organs and the scene's text, from the log and
///                    its folder
///
/// A channel's type is that of its first message of a known type. Messages of other types or sizes,
/// and those with time stamps before 0 or after the year 2554, are skipped and counted. `channels`
/// empty: all. The file appears when it is complete and replaces one of its name. One pass; memory
/// as for McapWriter. `at_event`: as for ExportCsv. Throws InputError if a file cannot be used, `file` is the log itself, or a
/// requested channel is missing.
std::vector<ExportedChannel> ExportMcap(
    const std::string& log, const std::filesystem::path& file,
    const std::vector<std::string>& channels, const MessageSchemas& schemas,
    const std::function<void()>& at_event = [] {});

}  // namespace hpdm
