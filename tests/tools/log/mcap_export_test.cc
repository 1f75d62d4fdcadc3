#include "tools/log/mcap_export.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <span>
#include <string_view>

#include "tests/support/mcap_export_fixture.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// The values of a JSON message in order; names without the numbers of elements.
using Leaves = std::vector<std::pair<std::string, Json>>;

void AddLeaves(const Json& json, const std::string& name, Leaves* leaves) {
  if (json.is_object()) {
    for (const auto& [key, value] : json.items())
      AddLeaves(value, name.empty() ? key : name + "." + key, leaves);
  } else if (json.is_array()) {
    for (const Json& item : json) AddLeaves(item, name, leaves);
  } else {
    leaves->emplace_back(name, json);
  }
}

std::string WithoutNumbers(std::string_view name) {
  std::string kept;
  int depth = 0;
  for (const char c : name) {
    depth += c == '[';
    if (depth == 0) kept += c;
    depth -= c == ']';
  }
  return kept;
}

/// Every value of the LCM message is in the JSON, under its name and in its place, and no other.
void ExpectSame(const Json& json, const LcmStruct& type, std::span<const std::uint8_t> bytes) {
  Leaves leaves;
  AddLeaves(json, "", &leaves);
  std::size_t i = 0;
  MessageSchemas::Hpdm().Decode(type, bytes, [&](const MessageValue& value) {
    ASSERT_LT(i, leaves.size());
    const auto& [name, leaf] = leaves[i++];
    ASSERT_EQ(name, WithoutNumbers(value.name));
    if (const auto* integer = std::get_if<std::int64_t>(&value.value)) {
      ASSERT_EQ(leaf.is_boolean() ? leaf.get<bool>() : leaf.get<std::int64_t>(), *integer) << name;
    } else if (const auto* real = std::get_if<double>(&value.value)) {
      ASSERT_EQ(leaf.get<double>(), *real) << name;  // exactly
    } else {
      ASSERT_EQ(leaf.get<std::string>(), std::get<std::string_view>(value.value)) << name;
    }
  });
  EXPECT_EQ(i, leaves.size());
}

TEST_F(McapExportTest, EveryMessageOfASessionIsItsLcmMessage) {
  RecordSession(1200);
  const auto exported = Export();
  const McapFile file = File();
  EXPECT_GT(file.chunks, 1u);
  LogReader reader(log_);
  LogEvent event;
  std::size_t i = 0;
  std::set<std::string> types;
  for (; reader.Next(&event); ++i) {
    ASSERT_LT(i, file.messages.size());
    const McapFile::Message& message = file.messages[i];
    const McapFile::Channel& channel = file.channels.at(message.channel);
    const LcmStruct* type = MessageSchemas::Hpdm().Find(event.data);
    ASSERT_NE(type, nullptr);
    types.insert(type->name);
    EXPECT_EQ(channel.topic, event.channel);
    EXPECT_EQ(channel.encoding, "json");
    EXPECT_EQ(file.schemas.at(channel.schema).name, type->name);
    EXPECT_EQ(message.log_time, static_cast<std::uint64_t>(event.time_us) * 1000);
    const Json json = Json::parse(message.data);
    EXPECT_EQ(message.sequence, json["sequence"].get<std::uint32_t>());
    EXPECT_EQ(message.publish_time,
              json.contains("time_ns") ? json["time_ns"].get<std::uint64_t>() : message.log_time);
    ExpectSame(json, *type, event.data);
  }
  EXPECT_EQ(i, file.messages.size());
  EXPECT_GE(types.size(), 6u) << "tool, force, contact, organ, mesh, event";
  std::uint64_t reported = 0;
  for (const ExportedChannel& channel : exported) reported += channel.messages;
  EXPECT_EQ(reported, i);

  const McapFile::Fields session = file.metadata.at("hpdm.session");
  EXPECT_EQ(session.at("session.start"), "instruments: probe");
  EXPECT_EQ(session.at("organs"), "liver");
  EXPECT_EQ(session.at("scene.toml"), kMcapScene);
}

TEST_F(McapExportTest, ASceneThatIsALinkOutOfTheFolderIsLeftOut) {
  RecordSession(10);
  const ScratchFolder elsewhere;
  const fs::path secret = elsewhere / "secret.toml";
  WriteBytes(secret, "secret");
  fs::remove(folder_ / "scene.toml");
  fs::create_symlink(secret, folder_ / "scene.toml");
  Export();
  EXPECT_FALSE(File().metadata.at("hpdm.session").contains("scene.toml"));
}

/// Checks that every value has the schema's type, with the members in its order.
void ExpectFits(const Json& value, const Json& schema, const std::string& place) {
  ASSERT_TRUE(schema["type"].is_string()) << place;
  const std::string type = schema["type"];
  if (type == "object") {
    ASSERT_TRUE(value.is_object()) << place;
    ASSERT_EQ(value.size(), schema["properties"].size()) << place;
    auto expected = schema["properties"].begin();
    for (const auto& [key, member] : value.items()) {
      EXPECT_EQ(key, expected.key()) << place;
      ExpectFits(member, expected.value(), place + "." + key);
      ++expected;
    }
  } else if (type == "array") {
    ASSERT_TRUE(value.is_array()) << place;
    EXPECT_NE(schema["items"]["type"], "array") << place << ": Foxglove takes no nested arrays";
    for (const Json& item : value) ExpectFits(item, schema["items"], place + "[]");
  } else {
    EXPECT_TRUE((type == "integer" && value.is_number_integer()) ||
                (type == "number" && value.is_number()) ||
                (type == "boolean" && value.is_boolean()) ||
                (type == "string" && value.is_string()))
        << place;
  }
}

TEST_F(McapExportTest, MessagesFitTheSchemasOfTheirTypes) {
  RecordSession(100);
  Export();
  const McapFile file = File();
  for (const McapFile::Message& message : file.messages) {
    const McapFile::Schema& schema = file.schemas.at(file.channels.at(message.channel).schema);
    EXPECT_EQ(schema.encoding, "jsonschema");
    ExpectFits(Json::parse(message.data), Json::parse(schema.data), schema.name);
  }
}

TEST_F(McapExportTest, NumbersAndTextsKeepEveryDigitAndByteThatJsonHas) {
  {
    SessionLog log(log_, 0);
    device_t device{};
    device.sequence = std::numeric_limits<std::int64_t>::max();
    device.time_ns = std::numeric_limits<std::int64_t>::min();
    const double values[] = {0.1, -0.0, 5e-324, std::nan(""),
                             -std::numeric_limits<double>::infinity()};
    std::copy(std::begin(values), std::end(values), device.joints);
    device.valid = true;
    Append(&log, kDeviceChannel, 7, device);
    event_t event{};
    event.text = "a \"quote\", a\nline, \xC3\xA9 and \xFF";
    Append(&log, kEventChannel, 8, event);
  }
  Export();
  const McapFile file = File();
  EXPECT_EQ(file.messages[0].data,
            R"({"sequence":9223372036854775807,"time_ns":-9223372036854775808,"instrument":0,)"
            R"("joints":[0.1,-0,5e-324,"NaN","-Infinity"],"valid":true,"pedal":false})");
  EXPECT_EQ(file.messages[0].sequence, 0xFFFFFFFFu) << "the low 32 bits";
  EXPECT_EQ(file.messages[0].publish_time, 7000u) << "there is no time before 0";
  EXPECT_EQ(Json::parse(file.messages[1].data)["text"],
            "a \"quote\", a\nline, \xC3\xA9 and \xEF\xBF\xBD");
}

TEST_F(McapExportTest, OrgansOfRepeatedMeshesAreNamedOnce) {
  {
    SessionLog log(log_, 0);
    for (int i = 0; i < 4; ++i) {
      mesh_t part{};
      part.organ = i % 2;
      part.name = i % 2 == 0 ? "liver" : "gallbladder";
      part.part_count = 1;
      Append(&log, kMeshChannel, i, part);
    }
  }
  Export();
  EXPECT_EQ(File().metadata.at("hpdm.session").at("organs"), "liver, gallbladder");
}

TEST_F(McapExportTest, DamagedLogsGiveSoundFilesOfWhatIsIntact) {
  WriteEvents(12);
  const std::string whole = ReadFile(log_);
  const auto check = [&](const std::string& bytes) {
    WriteBytes(log_, bytes);
    std::uint64_t events = 0, reported = 0;
    LogReader reader(log_);
    for (LogEvent event; reader.Next(&event);) ++events;
    for (const ExportedChannel& channel : Export()) reported += channel.messages + channel.skipped;
    EXPECT_EQ(reported, events);
    File();
  };
  for (std::size_t size = 0; size < whole.size(); size += 7) check(whole.substr(0, size));
  std::mt19937 random(3);
  for (int i = 0; i < 100; ++i) {
    std::string flipped = whole;
    flipped[random() % flipped.size()] ^= static_cast<char>(1 + random() % 255);
    check(flipped);
  }
}

TEST_F(McapExportTest, ForeignMessagesAreReportedAndLeftOutOrReadFromTheirFiles) {
  const std::string text = "package far; struct pose_t { byte id; double m[2][2]; }";
  const std::string name = "far.lcm";
  const MessageSchemas schemas = MessageSchemas::HpdmAnd(std::span(&text, 1), std::span(&name, 1));
  std::vector<std::uint8_t> pose;
  for (const LcmStruct& type : schemas.structs()) {
    if (type.name != "far.pose_t") continue;
    for (int i = 0; i < 8; ++i)
      pose.push_back(static_cast<std::uint8_t>(type.hash >> (56 - 8 * i)));
  }
  pose.resize(8 + 1 + 32);
  pose[8] = 200;
  {
    SessionLog log(log_, 0);
    log.Append("POSE", 5, pose);
    log.Append("POSE", 6, pose);
    log.Append("POSE", 6, std::vector<std::uint8_t>(pose.begin(), pose.end() - 1));
    event_t event{};
    Append(&log, kEventChannel, -1, event);
    Append(&log, kEventChannel, std::numeric_limits<std::int64_t>::max(), event);
  }
  auto exported = Export();
  ASSERT_EQ(exported.size(), 2u);
  EXPECT_EQ(exported[0].skipped, 2u) << "times that MCAP has no number for";
  EXPECT_EQ(exported[1].channel, "POSE");
  EXPECT_TRUE(exported[1].file.empty());
  EXPECT_TRUE(exported[1].type.starts_with("0x")) << exported[1].type;
  EXPECT_EQ(exported[1].skipped, 3u);
  EXPECT_EQ(File().messages.size(), 0u);

  exported = ExportMcap(log_, file_, {"POSE"}, schemas);
  ASSERT_EQ(exported.size(), 1u);
  EXPECT_EQ(exported[0].skipped, 1u) << "the torn one";
  const McapFile file = File();
  EXPECT_EQ(file.messages[1].data, R"({"id":200,"m":[0,0,0,0]})");
  EXPECT_EQ(file.messages[1].sequence, 2u) << "the type has none";
  EXPECT_EQ(file.messages[1].publish_time, file.messages[1].log_time);
}

}  // namespace
}  // namespace hpdm
