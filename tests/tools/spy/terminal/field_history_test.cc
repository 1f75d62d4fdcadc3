#include "tools/spy/terminal/field_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

class FieldHistoryTest : public testing::Test {
 protected:
  template <typename Message>
  bool Add(std::int64_t time_us, const Message& message) {
    EncodeMessage(message, &bytes_);
    const MessageSchemas& schemas = MessageSchemas::Hpdm();
    return history_.Add(time_us, schemas, *schemas.Find(bytes_), bytes_);
  }

  std::size_t Place(const std::string& name) const {
    for (std::size_t i = 0; i < history_.fields().size(); ++i) {
      if (history_.fields()[i].name == name) return i;
    }
    ADD_FAILURE() << "no field " << name;
    return 0;
  }
  const FieldHistory::Field& Field(const std::string& name) const {
    return history_.fields()[Place(name)];
  }
  std::vector<double> Curve(const std::string& name, std::size_t bins_each,
                            std::size_t columns) const {
    std::vector<double> curve(columns);
    history_.Curve(Place(name), bins_each, curve);
    return curve;
  }

  static tool_t Tool(double value, int tools = 1) {
    tool_t tool{};
    tool.tool_count = tools;
    tool.tools.resize(static_cast<std::size_t>(tools));
    tool.tools[0].p_tip[2] = value;
    return tool;
  }

  FieldHistory history_;
  std::vector<std::uint8_t> bytes_;
};

TEST_F(FieldHistoryTest, KeepsTheNewestValueTheExtremesAndTheMeans) {
  // 1 kHz for 10 s: the mean of each tenth of a second is that of its hundred values.
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(Add(1'000 * i, Tool(i)));
  const FieldHistory::Field& field = Field("tools[0].p_tip[2]");
  EXPECT_EQ(std::get<double>(field.value), 9999);
  EXPECT_EQ(field.min, 0);
  EXPECT_EQ(field.max, 9999);
  const std::vector<double> curve = Curve("tools[0].p_tip[2]", 5, 20);
  for (int c = 0; c < 20; ++c)
    EXPECT_DOUBLE_EQ(curve[static_cast<std::size_t>(c)], 500 * c + 249.5);
}

TEST_F(FieldHistoryTest, AMeanStaysAsItIsWhileItMovesToTheLeft) {
  std::vector<double> before;
  for (int i = 0; i < 400; ++i) {
    ASSERT_TRUE(Add(50'000 * i, Tool(std::sin(0.1 * i))));
    const std::vector<double> curve = Curve("tools[0].p_tip[2]", 5, 20);
    const bool moved = i % 10 == 0;  // columns of half a second, messages of 50 ms
    for (std::size_t c = 1; c + 1 < curve.size() && !before.empty(); ++c) {
      const double was = before[moved ? c + 1 : c];
      EXPECT_TRUE(std::isnan(was) || curve[c] == was) << i << ' ' << c;
    }
    before = curve;
  }
}

TEST_F(FieldHistoryTest, ASilentChannelHoldsItsLastValue) {
  ASSERT_TRUE(Add(0, Tool(1)));
  ASSERT_TRUE(Add(3'000'000, Tool(5)));
  const std::vector<double> curve = Curve("tools[0].p_tip[2]", 1, 100);
  EXPECT_TRUE(std::isnan(curve[68]));
  for (int c = 69; c < 99; ++c) EXPECT_EQ(curve[static_cast<std::size_t>(c)], 1);
  EXPECT_EQ(curve[99], 5);
}

TEST_F(FieldHistoryTest, TimeThatRunsFarBackRestartsTheHistory) {
  ASSERT_TRUE(Add(100'000'000, Tool(1)));
  ASSERT_TRUE(Add(5'000'000, Tool(2)));
  const std::vector<double> curve = Curve("tools[0].p_tip[2]", 1, 100);
  EXPECT_TRUE(std::isnan(curve[98]));
  EXPECT_EQ(curve[99], 2);
}

TEST_F(FieldHistoryTest, AnArrayThatGrowsAndShrinksKeepsItsOrder) {
  ASSERT_TRUE(Add(0, Tool(1, 1)));
  const std::size_t one = history_.fields().size();
  ASSERT_TRUE(Add(1, Tool(1, 2)));
  EXPECT_GT(history_.fields().size(), one);
  EXPECT_TRUE(Field("tools[1].p_tip[0]").present);
  EXPECT_GT(Place("tools[1].joints[0]"), Place("tools[0].device_valid"));
  ASSERT_TRUE(Add(2, Tool(1, 1)));
  EXPECT_FALSE(Field("tools[1].p_tip[0]").present);
  EXPECT_TRUE(Field("tools[0].p_tip[0]").present);
}

TEST_F(FieldHistoryTest, NotANumberSpoilsNothing) {
  for (const double value : {1.0, std::nan(""), std::numeric_limits<double>::infinity(), 3.0}) {
    ASSERT_TRUE(Add(0, Tool(value)));
  }
  EXPECT_EQ(Field("tools[0].p_tip[2]").max, 3);
  EXPECT_EQ(Curve("tools[0].p_tip[2]", 5, 20).back(), 2);
}

TEST_F(FieldHistoryTest, ALargeMessageIsCutAndTheRestCounted) {
  mesh_t mesh{};
  mesh.vertex_value_count = 12'000;
  mesh.vertices.resize(12'000);
  ASSERT_TRUE(Add(0, mesh));
  ASSERT_TRUE(Add(1, mesh));
  EXPECT_EQ(history_.fields().size(), FieldHistory::kMaxFields);
  std::size_t values = 0;
  MessageSchemas::Hpdm().Decode(*MessageSchemas::Hpdm().Find(bytes_), bytes_,
                                [&values](const MessageValue&) { ++values; });
  EXPECT_EQ(history_.left_out(), values - FieldHistory::kMaxFields);
}

TEST_F(FieldHistoryTest, TimeStampsAtBothEndsOfTheirRangeAreHeld) {
  std::mt19937_64 random(1);
  constexpr std::int64_t kEnds[] = {std::numeric_limits<std::int64_t>::min(), 0, -1,
                                    std::numeric_limits<std::int64_t>::max()};
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(Add(kEnds[random() % 4], Tool(1)));
    EXPECT_EQ(Curve("tools[0].p_tip[2]", 5, 20).back(), 1);
  }
}

}  // namespace
}  // namespace hpdm
