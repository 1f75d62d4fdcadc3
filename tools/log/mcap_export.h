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
/// Of each message: log_time is the log's time stamp; publish_time its member `time_ns` where its
/// type has one (the session's clock, or a driver's), else log_time; sequence the low 32 bits of
/// its member `sequence`, else its number on the channel from 1. Metadata "hpdm.session" holds what
/// the log and the folder around it tell of the session: instruments, organs, the scene's text.
///
/// A channel has the type of its first message of a known one; messages that are not readable as
/// that, or whose time stamp is before 0 or after the year 2554, are skipped and counted.
/// `channels` empty: all. The file appears when it is whole and replaces one of its name. One pass,
/// memory as for McapWriter. Throws InputError where a file cannot be used, `file` is the log
/// itself, or a channel that was asked for is missing.
std::vector<ExportedChannel> ExportMcap(const std::string& log, const std::filesystem::path& file,
                                        const std::vector<std::string>& channels,
                                        const MessageSchemas& schemas);

}  // namespace hpdm
