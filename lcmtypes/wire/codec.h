#pragma once

#include <lcm/lcm_coretypes.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/snapshots.h"
#include "hpdm/contact_t.hpp"
#include "hpdm/device_t.hpp"
#include "hpdm/event_t.hpp"
#include "hpdm/exercise_t.hpp"
#include "hpdm/force_t.hpp"
#include "hpdm/mesh_t.hpp"
#include "hpdm/organ_t.hpp"
#include "hpdm/stats_t.hpp"
#include "hpdm/teacher_t.hpp"
#include "hpdm/tool_t.hpp"
#include "lcmtypes/wire/message_hash.h"

/// Converts snapshots <-> LCM messages <-> bytes. Pure functions: no state, no file, no network.
///
/// 1. Values that a replay needs cross in double, bit for bit. Values that are only drawn cross in
///    float.
/// 2. Messages are reused by their owner: converting into one allocates only when it grows.
/// 3. `sequence` belongs to the sender and is not changed.
/// 4. FromMessage returns false, with unspecified outputs, if a message holds a value that no
///    sender of this project writes: a count beyond kMaxInstruments, an unknown contact kind, an
///    orientation that is not a unit quaternion.
namespace hpdm {

inline constexpr char kToolChannel[] = "HPDM_TOOL";
inline constexpr char kForceChannel[] = "HPDM_FORCE";
inline constexpr char kContactChannel[] = "HPDM_CONTACT";
inline constexpr char kOrganChannel[] = "HPDM_ORGAN";
inline constexpr char kMeshChannel[] = "HPDM_MESH";
inline constexpr char kStatsChannel[] = "HPDM_STATS";
inline constexpr char kEventChannel[] = "HPDM_EVENT";
inline constexpr char kDeviceChannel[] = "HPDM_DEVICE";
inline constexpr char kExerciseChannel[] = "HPDM_EXERCISE";
inline constexpr char kTeacherChannel[] = "HPDM_TEACHER";
/// All channels of a session.
inline constexpr std::string_view kSessionChannels[] = {
    kToolChannel,  kForceChannel, kContactChannel, kOrganChannel,    kMeshChannel,
    kStatsChannel, kEventChannel, kDeviceChannel,  kExerciseChannel, kTeacherChannel};

/// A haptic tick is two messages: its input and its output. Each FromMessage sets its own
/// fields of the sample and leaves the others (tool_count, tick and time_ns are in both).
void ToMessage(const HapticSample& sample, tool_t* message);
void ToMessage(const HapticSample& sample, force_t* message);
bool FromMessage(const tool_t& message, HapticSample* sample);
bool FromMessage(const force_t& message, HapticSample* sample);

/// A step whose patch no tick has used.
inline constexpr std::int64_t kNeverVisible = -1;

/// Converts a deformation step. `visible_tick` is the first tick that used its patch, or
/// kNeverVisible. The orientation crosses as a quaternion, so it comes back exact to a rounding.
void ToMessage(const StepSample& sample, std::int64_t visible_tick, contact_t* message);
bool FromMessage(const contact_t& message, StepSample* sample, std::int64_t* visible_tick);

/// Converts one organ's shape, with displacements in float, without its vertices and empty slots.
/// FromMessage resizes the arrays.
void ToMessage(const StepRecord& step, int organ, const OrganSnapshot& shape, organ_t* message);
bool FromMessage(const organ_t& message, OrganSnapshot* shape);

/// Converts one reading of instrument `instrument`. time_ns is in the driver's clock.
void ToMessage(const DeviceSample& sample, int instrument, device_t* message);
bool FromMessage(const device_t& message, DeviceSample* sample, int* instrument);

/// Encodes a message with its type's hash into `buffer` (resized) and returns its bytes. They are
/// valid until the buffer changes.
template <typename Message>
std::span<const std::uint8_t> EncodeMessage(const Message& message,
                                            std::vector<std::uint8_t>* buffer) {
  buffer->resize(static_cast<std::size_t>(message.getEncodedSize()));
  const int size = message.encode(buffer->data(), 0, static_cast<int>(buffer->size()));
  return {buffer->data(), static_cast<std::size_t>(size > 0 ? size : 0)};
}

/// True if arrays with the counts at the message's start can fit into the bytes.
/// The generated decoders trust the counts and would reserve up to 2^31 elements for a flipped bit.
bool CountsFit(std::span<const std::uint8_t> bytes, std::span<const int> element_sizes);

/// Returns the encoded size of an element of each of a type's arrays, in the order of the counts.
std::span<const int> ElementSizes(const tool_t&);
std::span<const int> ElementSizes(const force_t&);
std::span<const int> ElementSizes(const contact_t&);
std::span<const int> ElementSizes(const organ_t&);
std::span<const int> ElementSizes(const mesh_t&);
std::span<const int> ElementSizes(const stats_t&);
template <typename Message>
std::span<const int> ElementSizes(const Message&) {
  return {};
}

/// Place of a type's strings in a message, one behind the other.
struct StringPlace {
  std::size_t begin = 0;  ///< Bytes from the message's start.
  int count = 0;
};

/// True if the strings there fit into the bytes, each with a zero at its end and none before. The
/// generated decoders accept any last byte, and read 2 GB beyond the message for the length -2^31.
bool StringsFit(std::span<const std::uint8_t> bytes, StringPlace place);

StringPlace StringsOf(const event_t&);
StringPlace StringsOf(const mesh_t&);
StringPlace StringsOf(const exercise_t&);
StringPlace StringsOf(const teacher_t&);
template <typename Message>
StringPlace StringsOf(const Message&) {
  return {};
}

/// Decodes any bytes. False if they are not exactly one message of this type or of its former
/// version (message_hash.h). Reserves no more memory than a small multiple of `bytes` and never
/// throws, whatever the bytes are. EncodeMessage gives the same bytes back, except for a former
/// hash.
template <typename Message>
bool DecodeMessage(std::span<const std::uint8_t> bytes, Message* message) {
  if (bytes.size() > INT32_MAX || !CountsFit(bytes, ElementSizes(*message)) ||
      !StringsFit(bytes, StringsOf(*message))) {
    return false;
  }
  const int size = static_cast<int>(bytes.size());
  if (HasFormerHash(bytes, Message::getTypeName())) {
    constexpr int kBody = static_cast<int>(kHashBytes);
    return message->_decodeNoHash(bytes.data(), kBody, size - kBody) == size - kBody;
  }
  return message->decode(bytes.data(), 0, size) == size;
}

}  // namespace hpdm
