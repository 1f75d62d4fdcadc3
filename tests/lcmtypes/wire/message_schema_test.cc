#include "lcmtypes/wire/message_schema.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <sstream>

#include "engine/base/error.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

using Value = std::variant<std::int64_t, double, std::string>;
using Values = std::vector<std::pair<std::string, Value>>;

bool DecodeAll(const MessageSchemas& schemas, std::span<const std::uint8_t> bytes, Values* values) {
  values->clear();
  const LcmStruct* type = schemas.Find(bytes);
  return type != nullptr && schemas.Decode(*type, bytes, [&](const MessageValue& value) {
    Value kept;
    if (const auto* integer = std::get_if<std::int64_t>(&value.value)) kept = *integer;
    if (const auto* real = std::get_if<double>(&value.value)) kept = *real;
    if (const auto* text = std::get_if<std::string_view>(&value.value)) kept = std::string(*text);
    values->emplace_back(value.name, kept);
  });
}

template <typename Message>
std::vector<std::uint8_t> Encoded(const Message& message) {
  std::vector<std::uint8_t> bytes;
  EncodeMessage(message, &bytes);
  return bytes;
}

force_t SomeForce() {
  force_t force{};
  force.tool_count = 2;
  force.sequence = 7;
  force.time_ns = -3;
  force.tools.resize(2);
  force.tools[1].force[2] = -1.25;
  force.tools[1].organ = -1;
  force.tools[1].kind = 2;
  return force;
}

TEST(MessageSchema, TheTypesOfThisPackageHaveTheHashesOfTheirGeneratedCoders) {
  std::map<std::string, std::int64_t> hashes;
  for (const LcmStruct& type : MessageSchemas::Hpdm().structs()) hashes[type.name] = type.hash;
  EXPECT_EQ(hashes.at("hpdm.tool_t"), tool_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.force_t"), force_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.contact_t"), contact_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.organ_t"), organ_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.mesh_t"), mesh_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.stats_t"), stats_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.event_t"), event_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.device_t"), device_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.exercise_t"), exercise_t::getHash());
  EXPECT_EQ(hashes.at("hpdm.teacher_t"), teacher_t::getHash());
}

TEST(MessageSchema, MessagesOfVersion01AreReadUnderTodaysNames) {
  organ_t organ{};
  organ.organ = 3;
  std::vector<std::uint8_t> bytes = Encoded(organ);
  const std::vector<std::uint8_t> former = {0xb5, 0xe7, 0x87, 0xd5, 0x10, 0xed, 0xf6, 0x69};
  std::copy(former.begin(), former.end(), bytes.begin());
  const std::string text = "package foreign; struct pose_t { double p[3]; }";
  const std::string name = "foreign.lcm";
  const MessageSchemas with_more = MessageSchemas::HpdmAnd({&text, 1}, {&name, 1});
  for (const MessageSchemas* schemas : {&MessageSchemas::Hpdm(), &with_more}) {
    EXPECT_EQ(schemas->TypeOf(bytes), "hpdm.organ_t");
    Values values;
    ASSERT_TRUE(DecodeAll(*schemas, bytes, &values));
    const std::map<std::string, Value> by_name(values.begin(), values.end());
    EXPECT_EQ(by_name.at("organ"), Value(std::int64_t{3}));
  }
  const std::pair<std::uint64_t, std::string> others[] = {
      {0x8347b939b5770597, "0x8347b939b5770597"}, {0x552593ad56d352f2, "0x552593ad56d352f2"}};
  for (const auto& [hash, type] : others) {
    for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(hash >> (56 - 8 * i));
    EXPECT_EQ(MessageSchemas::Hpdm().TypeOf(bytes), type)
        << "0.1's tool_t and contact_t have other bytes";
  }
  // Types from files alone are not this package's.
  const std::string_view texts[] = {text};
  EXPECT_EQ(MessageSchemas(texts, {&name, 1}).Find(bytes), nullptr);
}

TEST(MessageSchema, ValuesComeWithTheirNamesInOrder) {
  Values values;
  ASSERT_TRUE(DecodeAll(MessageSchemas::Hpdm(), Encoded(SomeForce()), &values));
  EXPECT_EQ(values[0], (std::pair<std::string, Value>("tool_count", std::int64_t{2})));
  const std::map<std::string, Value> by_name(values.begin(), values.end());
  EXPECT_EQ(by_name.size(), values.size());
  EXPECT_EQ(by_name.at("sequence"), Value(std::int64_t{7}));
  EXPECT_EQ(by_name.at("time_ns"), Value(std::int64_t{-3}));
  EXPECT_EQ(by_name.at("tools[1].force[2]"), Value(-1.25));
  EXPECT_EQ(by_name.at("tools[1].organ"), Value(std::int64_t{-1}));
  EXPECT_EQ(by_name.at("tools[1].kind"), Value(std::int64_t{2}));

  event_t event{};
  event.name = "log.failed";
  ASSERT_TRUE(DecodeAll(MessageSchemas::Hpdm(), Encoded(event), &values));
  EXPECT_EQ(values[3].second, Value(std::string("log.failed")));
}

TEST(MessageSchema, FloatsAndNestedDimensionsAreRead) {
  organ_t organ{};
  organ.value_count = 3;
  organ.displacements = {1.5f, -2.5f, 0.f};
  contact_t contact{};
  contact.tool_count = 1;
  contact.tools.resize(1);
  contact.tools[0].compliance[1][2] = 0.125;
  Values values;
  ASSERT_TRUE(DecodeAll(MessageSchemas::Hpdm(), Encoded(organ), &values));
  const auto found = std::find_if(values.begin(), values.end(),
                                  [](const auto& v) { return v.first == "displacements[1]"; });
  ASSERT_NE(found, values.end());
  EXPECT_EQ(found->second, Value(-2.5));
  ASSERT_TRUE(DecodeAll(MessageSchemas::Hpdm(), Encoded(contact), &values));
  const std::map<std::string, Value> by_name(values.begin(), values.end());
  EXPECT_EQ(by_name.at("tools[0].compliance[1][2]"), Value(0.125));
}

TEST(MessageSchema, NoPrefixAndNoFlippedByteIsTrusted) {
  const std::vector<std::uint8_t> whole = Encoded(SomeForce());
  Values values;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(DecodeAll(MessageSchemas::Hpdm(), std::span(whole).first(size), &values)) << size;
  }
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::uint8_t> damaged = whole;
    damaged[8 + random() % (damaged.size() - 8)] ^= static_cast<std::uint8_t>(1 + random() % 255);
    DecodeAll(MessageSchemas::Hpdm(), damaged, &values);  // ends, within the memory of its bytes
    EXPECT_LT(values.size(), whole.size());
  }
}

TEST(MessageSchema, ForeignTypesAreReadFromTheirFiles) {
  const std::string_view text = R"(package foreign; /* two
    lines */ struct pose_t { const int32_t ONE = 1, TWO = 2; int64_t utime; double p[3], q[4]; }
    struct list_t { int16_t n; pose_t poses[n]; byte raw[2]; string name; })";
  const std::string name = "foreign.lcm";
  const MessageSchemas schemas(std::span(&text, 1), std::span(&name, 1));
  ASSERT_EQ(schemas.structs().size(), 2u);
  EXPECT_EQ(schemas.structs()[0].members.size(), 3u);
  std::vector<std::uint8_t> bytes(8);
  for (int i = 0; i < 8; ++i) {
    bytes[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(schemas.structs()[1].hash >> (56 - 8 * i));
  }
  bytes.insert(bytes.end(), {0, 0, 200, 1, 0, 0, 0, 2, 'a', 0});
  Values values;
  ASSERT_TRUE(DecodeAll(schemas, bytes, &values));
  EXPECT_EQ(values[1].second, Value(std::int64_t{200}));  // a byte has no sign
  EXPECT_EQ(values[3].second, Value(std::string("a")));
}

/// Returns the error of a text; empty if it is valid.
std::string SchemaError(std::string_view text) {
  const std::string name = "bad.lcm";
  try {
    MessageSchemas(std::span(&text, 1), std::span(&name, 1));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(MessageSchema, BadTextsNameTheirPlaceAndRemedy) {
  EXPECT_NE(SchemaError("struct a {\n int32_t x[n]; }").find("bad.lcm:2: the size 'n'"),
            std::string::npos);
  EXPECT_NE(SchemaError("struct a { b_t x; }").find("which is missing"), std::string::npos);
  EXPECT_NE(SchemaError("struct a { int8_t x").find("ends too early"), std::string::npos);
  EXPECT_NE(SchemaError("enum a { }").find("expected struct"), std::string::npos);
}

TEST(MessageSchema, QuotedTextCannotBreakTheLine) {
  EXPECT_NE(SchemaError("struct a\x01\n{}").find("found '?'"), std::string::npos);
  EXPECT_LT(SchemaError("struct a { " + std::string(100'000, 'b') + " x; }").size(), 200u);
}

// Without a bound, 2^48 ways through the types would be followed for one hash.
TEST(MessageSchema, TypesThatHoldTooManyTypesAreRefusedAtOnce) {
  std::ostringstream text;
  text << "struct t0 { byte a; }\n";
  for (int i = 1; i <= 48; ++i) text << "struct t" << i << " { t" << i - 1 << " a, b; }\n";
  EXPECT_NE(SchemaError(text.str()).find("holds too many structs inside of structs"),
            std::string::npos);
}

// Each dimension is a call within the one before: enough of them would overflow the stack.
TEST(MessageSchema, ArraysOfTooManyDimensionsAreRefused) {
  std::string dimensions;
  for (int i = 0; i < 16; ++i) dimensions += "[1]";
  EXPECT_EQ(SchemaError("struct a { byte x" + dimensions + "; }"), "");
  EXPECT_NE(
      SchemaError("struct a { byte x" + dimensions + "[1]; }").find("more than 16 dimensions"),
      std::string::npos);
}

// Empty structs take no byte: nothing in the message would end 7^16 of them.
TEST(MessageSchema, ArraysOfNothingEnd) {
  const std::string name = "empty.lcm";
  std::string text = "struct e {} struct a { e x";
  for (int i = 0; i < 16; ++i) text += "[7]";
  text += "; }";
  const std::string_view view = text;
  const MessageSchemas schemas(std::span(&view, 1), std::span(&name, 1));
  const std::vector<std::uint8_t> bytes(8);
  MessageOrder order;
  EXPECT_FALSE(schemas.Check(schemas.structs()[1], bytes, &order));
}

TEST(MessageSchema, AStringWithoutItsFinalZeroIsRefused) {
  event_t event{};
  event.name = "name";
  std::vector<std::uint8_t> bytes;
  EncodeMessage(event, &bytes);
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  const LcmStruct* type = schemas.Find(bytes);
  MessageOrder order;
  ASSERT_TRUE(type != nullptr && schemas.Check(*type, bytes, &order));
  bytes.back() = 'x';
  EXPECT_FALSE(schemas.Check(*type, bytes, &order));
}

}  // namespace
}  // namespace hpdm
