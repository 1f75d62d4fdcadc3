#include "lcmtypes/wire/comment_units.h"

#include <gtest/gtest.h>

#include <map>
#include <variant>

#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/message_schema.h"

/// Units that the comments of .lcm files state.

namespace hpdm {
namespace {

using Units = std::vector<std::string>;

TEST(CommentUnits, AUnitEndsTheCommentOrItsFirstPart) {
  EXPECT_EQ(CommentUnits(" tip, world, m", "p", 3), Units{"m"});
  EXPECT_EQ(CommentUnits(" m", "p", 3), Units{"m"});
  EXPECT_EQ(CommentUnits(" below the surface, m; 0 if none", "depth", -1), Units{"m"});
  EXPECT_EQ(CommentUnits(" added by the controller, N s/m.", "damping", -1), Units{"N s/m"});
  EXPECT_EQ(CommentUnits(" world, m^2", "amplitude", 3), Units{"m^2"});
  EXPECT_EQ(CommentUnits(" 0 closed .. 1 open", "jaw", -1), Units{});
  EXPECT_EQ(CommentUnits(" outward, unit, world", "normal", 3), Units{});
  EXPECT_EQ(CommentUnits("", "anything", -1), Units{});
}

TEST(CommentUnits, EachElementMayHaveItsOwn) {
  const char* joints = " pitch (rad), insertion (m), jaw (0 closed .. 1 open)";
  EXPECT_EQ(CommentUnits(joints, "joints", 3), (Units{"rad", "m", ""}));
  EXPECT_EQ(CommentUnits(joints, "joints", 4), Units{}) << "elements that it does not name";
}

TEST(CommentUnits, ANameEndsWithItsUnit) {
  EXPECT_EQ(CommentUnits(" driver's clock, any zero", "time_ns", -1), Units{"ns"});
  EXPECT_EQ(CommentUnits(" cycles / interval", "rate_hz", -1), Units{"Hz"});
}

TEST(CommentUnits, BelongToTheMemberOnTheirLine) {
  constexpr std::string_view kText =
      "struct a_t {\n  // above, m\n  double x;  // N\n  // N m\n  double y;\n"
      "  double z; /* Pa */ double w, v; // J\n}\n// rad\n";
  const std::string name = "a.lcm";
  const MessageSchemas schemas(std::span(&kText, 1), std::span(&name, 1));
  const std::vector<LcmMember>& members = schemas.structs()[0].members;
  ASSERT_EQ(members.size(), 5u);
  EXPECT_EQ(members[0].units, Units{"N"});
  EXPECT_EQ(members[1].units, Units{}) << "a comment on a line of its own";
  EXPECT_EQ(members[2].units, Units{});
  EXPECT_EQ(members[3].units, Units{"J"});
  EXPECT_EQ(members[4].units, Units{"J"});
}

TEST(CommentUnits, ReachEveryValueOfAMessage) {
  force_t force{};
  force.tool_count = 1;
  force.tools.resize(1);
  std::vector<std::uint8_t> buffer;
  const auto bytes = EncodeMessage(force, &buffer);
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  std::map<std::string, std::string> units;
  ASSERT_TRUE(schemas.Decode(*schemas.Find(bytes), bytes, [&](const MessageValue& value) {
    units[std::string(value.name)] = value.unit;
  }));
  EXPECT_EQ(units["time_ns"], "ns");
  EXPECT_EQ(units["sequence"], "");
  EXPECT_EQ(units["tools[0].force[2]"], "N");
  EXPECT_EQ(units["tools[0].effort[0]"], "N m");
  EXPECT_EQ(units["tools[0].effort[2]"], "N");
  EXPECT_EQ(units["tools[0].depth"], "m");
  EXPECT_EQ(units["tools[0].organ"], "");
  EXPECT_EQ(units["tools[0].damping"], "N s/m");

  device_t reading{};
  const auto reading_bytes = EncodeMessage(reading, &buffer);
  const LcmStruct* device = schemas.Find(reading_bytes);
  ASSERT_TRUE(schemas.Decode(*device, reading_bytes, [&](const MessageValue& value) {
    units[std::string(value.name)] = value.unit;
  }));
  EXPECT_EQ(units["joints[1]"], "rad");
  EXPECT_EQ(units["joints[2]"], "m");
  EXPECT_EQ(units["joints[4]"], "");
}

}  // namespace
}  // namespace hpdm
