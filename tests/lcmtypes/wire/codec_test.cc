#include "lcmtypes/wire/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "lcmtypes/wire/message_schema.h"
#include "tests/support/random_sample.h"

namespace hpdm {
namespace {

/// Returns the message as it is after the wire.
template <typename Message>
Message Carry(const Message& message) {
  std::vector<std::uint8_t> buffer;
  Message received;
  EXPECT_TRUE(DecodeMessage(EncodeMessage(message, &buffer), &received));
  return received;
}

TEST(Codec, AHapticTickComesBackBitForBit) {
  Random random(1);
  for (int tool_count : {0, 1, 2}) {
    const HapticSample sent = random.Tick(tool_count);
    tool_t tool{};
    force_t force{};
    ToMessage(sent, &tool);
    ToMessage(sent, &force);
    HapticSample received;
    ASSERT_TRUE(FromMessage(Carry(tool), &received));
    ASSERT_TRUE(FromMessage(Carry(force), &received));
    ExpectSame(sent, received);
  }
}

TEST(Codec, NanAndInfinityCrossUnchanged) {
  HapticSample sent;
  sent.tool_count = 1;
  sent.tools[0].reaction_W.x() = std::numeric_limits<double>::quiet_NaN();
  sent.tools[0].force_W.y() = -std::numeric_limits<double>::infinity();
  force_t force{};
  ToMessage(sent, &force);
  HapticSample received;
  ASSERT_TRUE(FromMessage(Carry(force), &received));
  EXPECT_TRUE(std::isnan(received.tools[0].reaction_W.x()));
  EXPECT_EQ(received.tools[0].force_W.y(), -std::numeric_limits<double>::infinity());
}

TEST(Codec, AStepComesBackWithItsVisibleTick) {
  Random random(2);
  for (const int organ_count : {0, 1, kMaxOrgans}) {
    const StepSample sent = random.Step(organ_count, 2);
    contact_t message{};
    ToMessage(sent, 1240, &message);
    StepSample received;
    std::int64_t visible_tick = 0;
    ASSERT_TRUE(FromMessage(Carry(message), &received, &visible_tick));
    EXPECT_EQ(visible_tick, 1240);
    ExpectSame(sent, received);
  }
}

/// The values of messages that were 0 so far, by name.
class ZeroValues {
 public:
  template <typename Message>
  void Add(const Message& message) {
    std::vector<std::uint8_t> bytes;
    const auto encoded = EncodeMessage(message, &bytes);
    const MessageSchemas& schemas = MessageSchemas::Hpdm();
    ASSERT_TRUE(schemas.Decode(*schemas.Find(encoded), encoded, [this](const MessageValue& value) {
      const bool zero = std::visit(
          [](const auto& x) {
            using Value = std::decay_t<decltype(x)>;
            if constexpr (std::is_arithmetic_v<Value>) return x == Value{0};
            return false;
          },
          value.value);
      const auto [at, first] = zero_.try_emplace(std::string(value.name), zero);
      if (!first) at->second = at->second && zero;
    }));
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& [name, zero] : zero_) {
      if (zero) names.push_back(name);
    }
    return names;
  }

 private:
  std::map<std::string, bool> zero_;
};

// A member of an .lcm file that is missing in sample_fields.h would stay 0.
TEST(Codec, TheFieldListHasEveryMemberOfItsMessages) {
  Random random(6);
  ZeroValues tools, forces, contacts;
  for (int i = 0; i < 100; ++i) {
    const HapticSample tick = random.Tick(2);
    tool_t tool{};
    force_t force{};
    contact_t contact{};
    ToMessage(tick, &tool);
    ToMessage(tick, &force);
    ToMessage(random.Step(2, 2), 1, &contact);
    tools.Add(tool);
    forces.Add(force);
    contacts.Add(contact);
  }
  const std::vector<std::string> sequence = {"sequence"};  // the sender's
  EXPECT_EQ(tools.Names(), sequence);
  EXPECT_EQ(forces.Names(), sequence);
  EXPECT_EQ(contacts.Names(), sequence);
}

TEST(Codec, DisplacementsComeBackInFloatAndFitOneDatagram) {
  OrganSnapshot sent;
  sent.control_displacements = Points::Random(1000, 3) * 0.05;
  sent.offset_W = Vector3d(0.001, -0.002, 1.0 / 3);
  sent.local_functions = std::vector<int>(128, 7);
  sent.local_displacements = Points::Random(128, 3) * 0.05;
  sent.indentation_count = kMaxInstruments;
  for (IndentationSnapshot& indentation : sent.indentations) {
    indentation = {Vector3d::Random(), Vector3d::UnitX(), 0.0025, 0.02, Vector3d::Random()};
  }
  organ_t message{};
  ToMessage(StepRecord(), 1, sent, &message);
  EXPECT_LT(message.getEncodedSize(), 60'000);
  OrganSnapshot received;
  ASSERT_TRUE(FromMessage(Carry(message), &received));
  // Half a unit in the last place of a float, relative to the largest value.
  const auto expect_near = [](const Points& a, const Points& b) {
    ASSERT_EQ(a.rows(), b.rows());
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 0.05 * 6e-8);
  };
  expect_near(received.control_displacements, sent.control_displacements);
  expect_near(received.local_displacements, sent.local_displacements);
  EXPECT_EQ(received.offset_W, sent.offset_W);
  EXPECT_EQ(received.local_functions, sent.local_functions);
  ASSERT_EQ(received.indentation_count, sent.indentation_count);
  for (int i = 0; i < sent.indentation_count; ++i) {
    EXPECT_EQ(received.indentations[i].p_rest_W, sent.indentations[i].p_rest_W);
    EXPECT_EQ(received.indentations[i].normal_W, sent.indentations[i].normal_W);
    EXPECT_EQ(received.indentations[i].amplitude_W, sent.indentations[i].amplitude_W);
    EXPECT_EQ(received.indentations[i].radius, sent.indentations[i].radius);
    EXPECT_EQ(received.indentations[i].resolved_radius, sent.indentations[i].resolved_radius);
  }

  ToMessage(StepRecord(), 0, OrganSnapshot(), &message);
  ASSERT_TRUE(FromMessage(Carry(message), &received));
  EXPECT_EQ(received.control_displacements.rows(), 0) << "a rigid organ has no control points";
}

// lcmtypes/README.md states this size.
TEST(Codec, AnOrganTakesTwelveBytesAControlPointSixteenALocalFunctionAndEightyEightAnIndentation) {
  for (const int points : {0, 64, 1000, 5000}) {
    for (const int local : {0, 64, 250}) {
      for (int indentations = 0; indentations <= kMaxInstruments; ++indentations) {
        OrganSnapshot shape;
        shape.control_displacements = Points::Zero(points, 3);
        shape.local_functions = std::vector<int>(static_cast<std::size_t>(local));
        shape.local_displacements = Points::Zero(local, 3);
        shape.indentation_count = indentations;
        organ_t message{};
        ToMessage(StepRecord(), 0, shape, &message);
        const int bytes = 76 + 12 * points + 16 * local + 88 * indentations;
        EXPECT_EQ(message.getEncodedSize(), bytes);
        // The aim: whole in one datagram, which holds 65 kB.
        if (points <= 1000) {
          EXPECT_LE(bytes, 60'000);
        }
      }
    }
  }
}

TEST(Codec, EmptySlotsStayAtHome) {
  OrganSnapshot sent;
  sent.local_functions = {-1, 12, -1, 3};
  sent.local_displacements = Points::Random(4, 3);
  organ_t message{};
  ToMessage(StepRecord(), 0, sent, &message);
  OrganSnapshot received;
  ASSERT_TRUE(FromMessage(Carry(message), &received));
  EXPECT_EQ(received.local_functions, (std::vector<int>{12, 3}));
  EXPECT_LT((received.local_displacements.row(1) - sent.local_displacements.row(3)).norm(), 1e-6);
}

TEST(Codec, ADeviceReadingComesBack) {
  DeviceSample sent;
  sent.sequence = 42;
  sent.time_ns = 123;
  sent.joints << 0.1, -0.2, 0.15, 3, 0.5;
  sent.valid = true;
  device_t message{};
  ToMessage(sent, 1, &message);
  DeviceSample received;
  int instrument = -1;
  ASSERT_TRUE(FromMessage(Carry(message), &received, &instrument));
  EXPECT_EQ(instrument, 1);
  EXPECT_EQ(received.sequence, sent.sequence);
  EXPECT_EQ(received.time_ns, sent.time_ns);
  EXPECT_EQ(received.joints, sent.joints);
  EXPECT_TRUE(received.valid);
  message.instrument = kMaxInstruments;
  EXPECT_FALSE(FromMessage(message, &received, &instrument));
}

TEST(Codec, ValuesThatNoSenderWritesAreRefused) {
  HapticSample sample;
  sample.tool_count = 1;
  force_t force{};
  ToMessage(sample, &force);
  force.tools[0].kind = 3;
  EXPECT_FALSE(FromMessage(force, &sample));
  ToMessage(sample, &force);
  force.tools.resize(3);
  force.tool_count = 3;
  EXPECT_FALSE(FromMessage(force, &sample));

  tool_t tool{};
  ToMessage(sample, &tool);
  tool.tools[0].instrument_index = kMaxHeld;
  EXPECT_FALSE(FromMessage(tool, &sample));

  const auto refused = [](const std::function<void(contact_t*)>& change) {
    StepSample step;
    step.tool_count = 1;
    step.organ_count = 1;
    contact_t contact{};
    ToMessage(step, kNeverVisible, &contact);
    std::int64_t tick = 0;
    EXPECT_TRUE(FromMessage(contact, &step, &tick));
    change(&contact);
    return !FromMessage(contact, &step, &tick);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](contact_t* m) { m->tools[0].orientation[0] = kNan; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->tools[0].orientation[0] = 1.1; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->tools[0].instrument_index = -1; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->tools[0].kind = -1; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->tools[0].reaction = 2; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->organs[0].iterations = -1; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->organs[0].finite_strain_blend = 1.1; }));
  EXPECT_TRUE(refused([](contact_t* m) { m->organs[0].refinement_weight = kNan; }));
  EXPECT_TRUE(refused([](contact_t* m) {
    m->organ_count = kMaxOrgans + 1;
    m->organs.resize(kMaxOrgans + 1);
  }));

  organ_t organ{};
  organ.value_count = 4;
  organ.displacements.resize(4);
  OrganSnapshot shape;
  EXPECT_FALSE(FromMessage(organ, &shape));
  organ = {};
  organ.local_count = 1;
  organ.local_functions.resize(1);
  EXPECT_FALSE(FromMessage(organ, &shape)) << "a local function without its displacement";
  organ = {};
  organ.indentation_count = kMaxInstruments + 1;
  organ.indentations.resize(kMaxInstruments + 1);
  EXPECT_FALSE(FromMessage(organ, &shape));
}

TEST(Codec, EveryPrefixAndAnotherTypeAreRefused) {
  Random random(3);
  const HapticSample sample = random.Tick(2);
  force_t force{};
  ToMessage(sample, &force);
  std::vector<std::uint8_t> bytes;
  EncodeMessage(force, &bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(DecodeMessage({bytes.data(), size}, &force)) << size;
  }
  tool_t tool{};
  EXPECT_FALSE(DecodeMessage(bytes, &tool)) << "the type's hash differs";
  bytes.push_back(0);
  EXPECT_FALSE(DecodeMessage(bytes, &force)) << "a longer message is not ours either";
}

// The generated decoders reserve whatever a count claims; a count of 2^31 - 1 would take 16 GB.
TEST(Codec, AbsurdCountsReserveNothing) {
  std::vector<std::uint8_t> bytes;
  organ_t organ{};
  EncodeMessage(organ, &bytes);
  for (std::uint8_t high : {0x7F, 0xFF}) {
    std::memset(bytes.data() + 8, high, 4);
    EXPECT_FALSE(DecodeMessage(bytes, &organ));
    EXPECT_EQ(organ.displacements.capacity(), 0u);
  }
}

// For a length of -2^31 the generated decoder reads 2 GB beyond the message, and it takes any byte
// for the final zero.
TEST(Codec, StringsThatDoNotFitOrEndAreRefused) {
  event_t event{};
  event.name = "name";
  event.text = "text";
  std::vector<std::uint8_t> sound;
  EncodeMessage(event, &sound);
  ASSERT_TRUE(DecodeMessage(sound, &event));
  const std::size_t text_length = sound.size() - 5 - 4, last = sound.size() - 1;
  const auto refused = [&](std::size_t at, std::initializer_list<std::uint8_t> bytes) {
    std::vector<std::uint8_t> broken = sound;
    std::copy(bytes.begin(), bytes.end(), broken.begin() + static_cast<std::ptrdiff_t>(at));
    return !DecodeMessage(broken, &event);
  };
  EXPECT_TRUE(refused(text_length, {0x80, 0, 0, 0}));
  EXPECT_TRUE(refused(text_length, {0xFF, 0xFF, 0xFF, 0xFF}));
  EXPECT_TRUE(refused(text_length, {0, 0, 0, 0}));
  EXPECT_TRUE(refused(text_length, {0, 0, 0, 6}));
  EXPECT_TRUE(refused(last, {'x'})) << "no zero at the end";
  // The strings of the other types are where StringsOf() says.
  const auto breaks_its_last_string = [](auto message) {
    std::vector<std::uint8_t> bytes;
    EncodeMessage(message, &bytes);
    EXPECT_TRUE(DecodeMessage(bytes, &message));
    bytes.back() = 'x';
    return !DecodeMessage(bytes, &message);
  };
  exercise_t exercise{};
  exercise.name = exercise.instruction = exercise.last_error = "text";
  EXPECT_TRUE(breaks_its_last_string(exercise));
  teacher_t teacher{};
  teacher.text = "text";
  EXPECT_TRUE(breaks_its_last_string(teacher));
  EXPECT_TRUE(refused(last - 2, {0})) << "a zero before the end";
}

template <typename Message>
void DecodeWithFlippedBits(const Message& message, std::uint32_t seed) {
  std::vector<std::uint8_t> sound;
  EncodeMessage(message, &sound);
  std::mt19937 random(seed);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::uint8_t> bytes = sound;
    for (int flips = 1 + static_cast<int>(random() % 3); flips > 0; --flips) {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1u << random() % 8);
    }
    Message received;
    DecodeMessage(bytes, &received);
  }
}

TEST(Codec, FlippedBitsNeverCrashADecoder) {
  Random random(4);
  const HapticSample sample = random.Tick(2);
  tool_t tool{};
  ToMessage(sample, &tool);
  DecodeWithFlippedBits(tool, 1);
  organ_t organ{};
  OrganSnapshot shape;
  shape.control_displacements = Points::Random(10, 3);
  shape.local_functions = {1, 2};
  shape.local_displacements = Points::Random(2, 3);
  shape.indentation_count = 1;
  ToMessage(StepRecord(), 0, shape, &organ);
  DecodeWithFlippedBits(organ, 2);
  event_t event{};
  event.name = "name";
  event.text = "text";
  DecodeWithFlippedBits(event, 3);
  stats_t stats{};
  stats.bins.resize(3);
  stats.bin_count = 3;
  DecodeWithFlippedBits(stats, 4);
  mesh_t mesh{};
  mesh.name = "liver";
  DecodeWithFlippedBits(mesh, 5);
  contact_t contact{};
  StepSample step;
  step.tool_count = 1;
  step.organ_count = 2;
  ToMessage(step, 1, &contact);
  DecodeWithFlippedBits(contact, 6);
  exercise_t exercise{};
  exercise.name = "name";
  exercise.last_error = "error";
  DecodeWithFlippedBits(exercise, 7);
  teacher_t teacher{};
  teacher.text = "here";
  DecodeWithFlippedBits(teacher, 8);
}

}  // namespace
}  // namespace hpdm
