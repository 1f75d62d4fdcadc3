#include "lcmtypes/wire/message_hash.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "lcmtypes/wire/codec.h"
#include "tests/support/random_sample.h"

namespace hpdm {
namespace {

/// Returns the message's bytes with another hash at their start.
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
  EXPECT_FALSE(DecodeMessage(whole, &force)) << "the hash is of another type";
}

// The hash is the one that lcm-gen 1.3.1 gave to the type of version 0.1.
TEST(MessageHash, ShapesOfVersion01AreRead) {
  OrganSnapshot shape;
  shape.control_displacements = Points::Random(4, 3);
  shape.indentation_count = 1;
  shape.indentations[0] = {Vector3d::Random(), Vector3d::UnitX(), 0.0025, 0.02, Vector3d::Random()};
  organ_t organ{};
  ToMessage(StepRecord(), 0, shape, &organ);
  ExpectReadWithFormerHash(organ, 0xb5e787d510edf669);
}

}  // namespace
}  // namespace hpdm
