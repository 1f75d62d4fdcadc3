#include "lcmtypes/wire/codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <random>

namespace hpdm {
namespace {

class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double Real() { return std::normal_distribution<double>(0, 1)(engine_); }
  std::int64_t Integer() { return static_cast<std::int64_t>(engine_()); }
  Vector3d Vector() { return {Real(), Real(), Real()}; }

 private:
  std::mt19937_64 engine_;
};

HapticSample RandomSample(Random* random, int tool_count) {
  HapticSample s;
  s.tick = static_cast<std::uint64_t>(random->Integer());
  s.time_ns = random->Integer();
  s.device_time_ns = random->Integer();
  s.patch_number = static_cast<std::uint64_t>(random->Integer());
  s.patch_age_ns = random->Integer();
  s.wake_late_ns = random->Integer();
  s.written_ns = random->Integer();
  s.compute_ns = random->Integer();
  s.skipped = {3, 4, 0xFFFFFFFFu};
  s.tool_count = tool_count;
  for (int i = 0; i < tool_count; ++i) {
    ToolSample& t = s.tools[i];
    for (int k = 0; k < 5; ++k) t.joints[k] = random->Real();
    t.p_tip_W = random->Vector();
    t.v_tip_W = random->Vector();
    t.reaction_W = random->Vector();
    t.force_W = random->Vector();
    t.effort = random->Vector();
    t.depth = random->Real();
    t.organ = 2 * i - 1;
    t.kind = i == 0 ? ContactKind::kNone : ContactKind::kGrasp;
    t.guard_flags = kGuardClamped | 0x80000000u;
    t.energy = 0.125 * (i + 1);
    t.damping = 3.5 * i;
    t.device_time_ns = 123456789 + i;
    t.force_on = i == 0;
    t.device_valid = i == 1;
  }
  return s;
}

void ExpectSame(const HapticSample& a, const HapticSample& b) {
  EXPECT_EQ(a.tick, b.tick);
  EXPECT_EQ(a.time_ns, b.time_ns);
  EXPECT_EQ(a.device_time_ns, b.device_time_ns);
  EXPECT_EQ(a.patch_number, b.patch_number);
  EXPECT_EQ(a.patch_age_ns, b.patch_age_ns);
  EXPECT_EQ(a.wake_late_ns, b.wake_late_ns);
  EXPECT_EQ(a.written_ns, b.written_ns);
  EXPECT_EQ(a.compute_ns, b.compute_ns);
  EXPECT_EQ(a.skipped.late_wake_up, b.skipped.late_wake_up);
  EXPECT_EQ(a.skipped.long_compute, b.skipped.long_compute);
  EXPECT_EQ(a.skipped.stalled, b.skipped.stalled);
  ASSERT_EQ(a.tool_count, b.tool_count);
  for (int i = 0; i < a.tool_count; ++i) {
    const ToolSample &s = a.tools[i], &t = b.tools[i];
    EXPECT_EQ(s.joints, t.joints);
    EXPECT_EQ(s.p_tip_W, t.p_tip_W);
    EXPECT_EQ(s.v_tip_W, t.v_tip_W);
    EXPECT_EQ(s.reaction_W, t.reaction_W);
    EXPECT_EQ(s.force_W, t.force_W);
    EXPECT_EQ(s.effort, t.effort);
    EXPECT_EQ(s.depth, t.depth);
    EXPECT_EQ(s.organ, t.organ);
    EXPECT_EQ(s.kind, t.kind);
    EXPECT_EQ(s.guard_flags, t.guard_flags);
    EXPECT_EQ(s.energy, t.energy);
    EXPECT_EQ(s.damping, t.damping);
    EXPECT_EQ(s.device_time_ns, t.device_time_ns);
    EXPECT_EQ(s.force_on, t.force_on);
    EXPECT_EQ(s.device_valid, t.device_valid);
  }
}

/// A message over the wire and back.
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
    const HapticSample sent = RandomSample(&random, tool_count);
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
  StepSample sent;
  sent.organ_count = 2;
  sent.organs[0] = {3, false};
  sent.organs[1] = {1, true};
  sent.step = {7, 1234, 5'000'000, 4'000'000, 70'000, 900'000, 3, 1e-7, kStepBudgetSpent};
  sent.tool_count = 2;
  for (int i = 0; i < 2; ++i) {
    const Eigen::AngleAxisd rotation(random.Real(), random.Vector().normalized());
    sent.tools[i].X_WT = Eigen::Translation3d(random.Vector()) * rotation;
    sent.tools[i].p_trocar_W = random.Vector();
    sent.tools[i].v_tip_W = random.Vector();
    sent.tools[i].jaw = 0.25;
    sent.contacts[i].organ = i;
    sent.contacts[i].kind = ContactKind::kPress;
    sent.contacts[i].contact_W = random.Vector();
    sent.contacts[i].force_on_tissue_W = random.Vector();
    sent.contacts[i].shaft_contact = i == 1;
    sent.contacts[i].reaction = i == 1 ? ReactionType::kPaper : ReactionType::kLattice;
    sent.contacts[i].p_original_W = random.Vector();
    sent.contacts[i].normal_W = random.Vector();
    for (int d = 0; d < 3; ++d) {
      sent.contacts[i].compliance_W.col(d) = random.Vector();
      sent.contacts[i].coupling_W.col(d) = random.Vector();
    }
    sent.contacts[i].kernel_radius = random.Real();
  }
  sent.step.shed_level = 3;
  sent.organs[0].finite_strain_blend = 0.3;
  sent.organs[1].refinement_weight = 0.7;
  contact_t message{};
  ToMessage(sent, 1240, &message);
  StepSample received;
  std::int64_t visible_tick = 0;
  ASSERT_TRUE(FromMessage(Carry(message), &received, &visible_tick));
  EXPECT_EQ(visible_tick, 1240);
  EXPECT_EQ(received.step.number, sent.step.number);
  EXPECT_EQ(received.step.input_tick, sent.step.input_tick);
  EXPECT_EQ(received.step.time_ns, sent.step.time_ns);
  EXPECT_EQ(received.step.device_time_ns, sent.step.device_time_ns);
  EXPECT_EQ(received.step.wake_late_ns, sent.step.wake_late_ns);
  EXPECT_EQ(received.step.compute_ns, sent.step.compute_ns);
  EXPECT_EQ(received.step.iterations, sent.step.iterations);
  EXPECT_EQ(received.step.residual, sent.step.residual);
  EXPECT_EQ(received.step.flags, sent.step.flags);
  EXPECT_EQ(received.step.shed_level, sent.step.shed_level);
  ASSERT_EQ(received.organ_count, 2);
  for (int o = 0; o < 2; ++o) {
    EXPECT_EQ(received.organs[o].iterations, sent.organs[o].iterations);
    EXPECT_EQ(received.organs[o].out_of_time, sent.organs[o].out_of_time);
    EXPECT_EQ(received.organs[o].finite_strain_blend, sent.organs[o].finite_strain_blend);
    EXPECT_EQ(received.organs[o].refinement_weight, sent.organs[o].refinement_weight);
  }
  ASSERT_EQ(received.tool_count, 2);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(received.tools[i].X_WT.translation(), sent.tools[i].X_WT.translation());
    // A unit quaternion and back costs a few roundings of 1e-16.
    EXPECT_LT((received.tools[i].X_WT.linear() - sent.tools[i].X_WT.linear()).norm(), 1e-14);
    EXPECT_EQ(received.tools[i].p_trocar_W, sent.tools[i].p_trocar_W);
    EXPECT_EQ(received.tools[i].v_tip_W, sent.tools[i].v_tip_W);
    EXPECT_EQ(received.tools[i].jaw, sent.tools[i].jaw);
    EXPECT_EQ(received.contacts[i].organ, sent.contacts[i].organ);
    EXPECT_EQ(received.contacts[i].kind, sent.contacts[i].kind);
    EXPECT_EQ(received.contacts[i].contact_W, sent.contacts[i].contact_W);
    EXPECT_EQ(received.contacts[i].force_on_tissue_W, sent.contacts[i].force_on_tissue_W);
    EXPECT_EQ(received.contacts[i].shaft_contact, sent.contacts[i].shaft_contact);
    EXPECT_EQ(received.contacts[i].reaction, sent.contacts[i].reaction);
    EXPECT_EQ(received.contacts[i].p_original_W, sent.contacts[i].p_original_W);
    EXPECT_EQ(received.contacts[i].normal_W, sent.contacts[i].normal_W);
    EXPECT_EQ(received.contacts[i].compliance_W, sent.contacts[i].compliance_W);
    EXPECT_EQ(received.contacts[i].coupling_W, sent.contacts[i].coupling_W);
    EXPECT_EQ(received.contacts[i].kernel_radius, sent.contacts[i].kernel_radius);
  }
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

  StepSample step;
  step.tool_count = 1;
  contact_t contact{};
  ToMessage(step, kNeverVisible, &contact);
  contact.tools[0].orientation[0] = std::numeric_limits<double>::quiet_NaN();
  std::int64_t tick = 0;
  EXPECT_FALSE(FromMessage(contact, &step, &tick));
  ToMessage(step, kNeverVisible, &contact);
  contact.organ_count = kMaxOrgans + 1;
  contact.organs.resize(kMaxOrgans + 1);
  EXPECT_FALSE(FromMessage(contact, &step, &tick));

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
  const HapticSample sample = RandomSample(&random, 2);
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

/// The message's bytes with another hash at their start.
template <typename Message>
std::vector<std::uint8_t> WithHash(const Message& message, std::uint64_t hash) {
  std::vector<std::uint8_t> bytes;
  EncodeMessage(message, &bytes);
  for (std::size_t i = 0; i < kHashBytes; ++i) {
    bytes[i] = static_cast<std::uint8_t>(hash >> (56 - 8 * i));
  }
  return bytes;
}

/// Expects that the message's body is read with its type's hash of version 0.1, and with no other.
template <typename Message>
void ExpectReadWithFormerHash(const Message& sent, std::uint64_t former) {
  std::vector<std::uint8_t> current;
  EncodeMessage(sent, &current);
  Message received{};
  ASSERT_TRUE(DecodeMessage(WithHash(sent, former), &received));
  std::vector<std::uint8_t> again;
  EncodeMessage(received, &again);
  EXPECT_EQ(again, current) << "the same values under today's hash";
  for (int bit = 0; bit < 64; ++bit) {
    EXPECT_FALSE(DecodeMessage(WithHash(sent, former ^ std::uint64_t{1} << bit), &received)) << bit;
  }
  const std::vector<std::uint8_t> whole = WithHash(sent, former);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_FALSE(DecodeMessage({whole.data(), size}, &received)) << size;
  }
  force_t force{};
  EXPECT_FALSE(DecodeMessage(whole, &force)) << "it is the hash of another type";
}

// The hashes are those that lcm-gen 1.3.1 gave to the types of version 0.1.
TEST(Codec, MessagesOfVersion01AreRead) {
  Random random(5);
  tool_t tool{};
  HapticSample sample = RandomSample(&random, 2);
  sample.tools[1].instrument_index = 3;
  ToMessage(sample, &tool);
  ExpectReadWithFormerHash(tool, 0x8347b939b5770597);

  StepSample step;
  step.tool_count = 1;
  step.tools[0].instrument_index = 2;
  step.organ_count = 1;
  step.organs[0].finite_strain_blend = 0.25;
  step.organs[0].refinement_weight = 0.75;
  contact_t contact{};
  ToMessage(step, 7, &contact);
  ExpectReadWithFormerHash(contact, 0x552593ad56d352f2);

  OrganSnapshot shape;
  shape.control_displacements = Points::Random(4, 3);
  shape.indentation_count = 1;
  shape.indentations[0] = {Vector3d::Random(), Vector3d::UnitX(), 0.0025, 0.02, Vector3d::Random()};
  organ_t organ{};
  ToMessage(StepRecord(), 0, shape, &organ);
  ExpectReadWithFormerHash(organ, 0xb5e787d510edf669);
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
  const HapticSample sample = RandomSample(&random, 2);
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
}

}  // namespace
}  // namespace hpdm
