#include "tools/log/mcap_export.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>

#include "engine/base/error.h"
#include "engine/base/text_list.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tools/log/mcap_writer.h"
#include "tools/log/message_json.h"
#include "tools/session/session_path.h"
#include "tools/shared/staged_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

class McapExport {
 public:
  McapExport(StagedFile* file, const std::string& log, const MessageSchemas& schemas)
      : log_(log), schemas_(schemas), writer_(file, "hpdm") {}

  void Add(const LogEvent& event) {
    Channel& channel = channels_[event.channel];
    if (channel.type == nullptr) {
      channel.type = schemas_.Find(event.data);
      if (channel.exported.type.empty() || channel.type != nullptr) {
        channel.exported.type = schemas_.TypeOf(event.data);
      }
      if (channel.type != nullptr) Declare(event.channel, &channel);
    }
    if (channel.type == nullptr || !Write(event, &channel)) ++channel.exported.skipped;
  }

  bool Has(const std::string& channel) const { return channels_.contains(channel); }

  std::vector<ExportedChannel> Finish(const fs::path& file) {
    std::string organs;
    for (const auto& [number, name] : organs_) AppendToList(name, &organs);
    if (!organs.empty()) session_["organs"] = organs;
    AddScene();
    if (!session_.empty()) writer_.AddMetadata("hpdm.session", session_);
    writer_.Close();
    std::vector<ExportedChannel> exported;
    for (auto& [name, channel] : channels_) {
      channel.exported.channel = name;
      if (channel.type != nullptr) channel.exported.file = file;
      exported.push_back(channel.exported);
    }
    return exported;
  }

 private:
  struct Channel {
    const LcmStruct* type = nullptr;
    std::uint16_t number = 0;
    ExportedChannel exported;
  };

  void Declare(const std::string& name, Channel* channel) {
    const auto [schema, is_new] = schema_numbers_.try_emplace(channel->type);
    if (is_new) {
      schema->second = writer_.AddSchema(channel->type->name, "jsonschema",
                                         JsonSchemaOf(schemas_, *channel->type));
    }
    channel->number = writer_.AddChannel(schema->second, Utf8(name), "json", {});
  }

  bool Write(const LogEvent& event, Channel* channel) {
    constexpr std::int64_t kNanosecondsPerMicrosecond = 1000;
    MessageHeader header;
    if (schemas_.Find(event.data) != channel->type ||
        !MessageToJson(schemas_, *channel->type, event.data, &json_, &header) ||
        event.time_us < 0 ||
        static_cast<std::uint64_t>(event.time_us) >
            std::numeric_limits<std::uint64_t>::max() / kNanosecondsPerMicrosecond) {
      return false;
    }
    const std::uint64_t log_time =
        static_cast<std::uint64_t>(event.time_us) * kNanosecondsPerMicrosecond;
    const std::uint64_t publish_time = header.time_ns && *header.time_ns >= 0
                                           ? static_cast<std::uint64_t>(*header.time_ns)
                                           : log_time;
    ++channel->exported.messages;
    const auto sequence =
        static_cast<std::uint32_t>(header.sequence ? static_cast<std::uint64_t>(*header.sequence)
                                                   : channel->exported.messages);
    writer_.Write(channel->number, sequence, log_time, publish_time, json_);
    Note(event, channel->type->name);
    return true;
  }

  void Note(const LogEvent& event, const std::string& type) {
    event_t message;
    mesh_t part;
    if (type == "hpdm.event_t" && DecodeMessage(event.data, &message)) {
      if (message.name == "session.start") session_.try_emplace(message.name, Utf8(message.text));
    } else if (type == "hpdm.mesh_t" && DecodeMessage(event.data, &part) && part.part == 0 &&
               part.organ >= 0 && part.organ < kMaxOrgans) {
      organs_[part.organ] = Utf8(part.name);  // a live session repeats its meshes
    }
  }

  /// Adds the scene from the session's folder.
  void AddScene() {
    constexpr std::uintmax_t kMaxBytes = 1 << 20;
    const fs::path path = FileInside(fs::path(log_).parent_path(), "scene.toml");
    std::error_code missing;
    if (path.empty() || fs::file_size(path, missing) > kMaxBytes || missing) return;
    std::ifstream scene(path, std::ios::binary);
    session_["scene.toml"] = Utf8({std::istreambuf_iterator<char>(scene), {}});
  }

  const std::string& log_;
  const MessageSchemas& schemas_;
  McapWriter writer_;
  std::map<std::string, Channel> channels_;
  std::map<const LcmStruct*, std::uint16_t> schema_numbers_;
  std::string json_;
  McapWriter::Fields session_;
  std::map<std::int32_t, std::string> organs_;  // names by number
};

}  // namespace

std::vector<ExportedChannel> ExportMcap(const std::string& log, const fs::path& file,
                                        const std::vector<std::string>& channels,
                                        const MessageSchemas& schemas,
                                        const std::function<void()>& at_event) {
  LogReader reader(log);
  std::error_code none;
  if (fs::equivalent(log, file, none)) {
    throw InputError(file.string() + ": is the log itself; choose another --out");
  }
  StagedFile staged(file);
  McapExport out(&staged, log, schemas);
  LogEvent event;
  while (reader.Next(&event)) {
    at_event();
    if (channels.empty() ||
        std::find(channels.begin(), channels.end(), event.channel) != channels.end()) {
      out.Add(event);
    }
  }
  for (const std::string& channel : channels) {
    if (!out.Has(channel)) RefuseMissingChannel(log, channel);
  }
  std::vector<ExportedChannel> exported = out.Finish(file);
  staged.Commit();
  return exported;
}

}  // namespace hpdm
