#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/message_schema.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

template <typename Message>
std::vector<std::uint8_t> Encoded(const Message& message) {
  std::vector<std::uint8_t> buffer;
  EncodeMessage(message, &buffer);
  return buffer;
}

/// Ways to a snapshot and back: what a message becomes by one such way stays as it is.
template <typename Message, typename Way>
void EnsureStays(const Message& message, const Way& way) {
  Message once{}, twice{};
  if (!way(message, &once)) return;
  HPDM_ENSURE(way(once, &twice));
  HPDM_ENSURE(Encoded(once) == Encoded(twice));
}

bool Way(const tool_t& from, tool_t* to) {
  HapticSample sample;
  if (!FromMessage(from, &sample)) return false;
  ToMessage(sample, to);
  return true;
}
bool Way(const force_t& from, force_t* to) {
  HapticSample sample;
  if (!FromMessage(from, &sample)) return false;
  ToMessage(sample, to);
  return true;
}
bool Way(const contact_t& from, contact_t* to) {
  StepSample sample;
  std::int64_t visible_tick = 0;
  if (!FromMessage(from, &sample, &visible_tick)) return false;
  ToMessage(sample, visible_tick, to);
  // The orientation alone changes, by roundings. It is a unit quaternion to 1e-9 (codec.h): by a
  // rotation matrix and back that error can triple.
  for (tool_contact_t& tool : to->tools) {
    Eigen::Map<Eigen::Vector4d> orientation(tool.orientation);
    HPDM_ENSURE(std::abs(orientation.squaredNorm() - 1) < 4e-9);
    orientation = Eigen::Vector4d::UnitX();
  }
  return true;
}
bool Way(const organ_t& from, organ_t* to) {
  OrganSnapshot shape;
  if (!FromMessage(from, &shape)) return false;
  StepRecord step;
  step.number = static_cast<std::uint64_t>(from.step);
  step.time_ns = from.time_ns;
  ToMessage(step, from.organ, shape, to);
  return true;
}
bool Way(const device_t& from, device_t* to) {
  DeviceSample sample;
  int instrument = -1;
  if (!FromMessage(from, &sample, &instrument)) return false;
  HPDM_ENSURE(instrument >= 0 && instrument < kMaxInstruments);
  ToMessage(sample, instrument, to);
  return true;
}
template <typename Message>
bool Way(const Message&, Message*) {
  return false;  // of no snapshot
}

bool HoldsZeroInString(const LcmStruct& type, Bytes bytes) {
  bool holds = false;
  MessageSchemas::Hpdm().Decode(type, bytes, [&](const MessageValue& value) {
    const auto* text = std::get_if<std::string_view>(&value.value);
    holds |= text != nullptr && text->find('\0') != std::string_view::npos;
  });
  return holds;
}

template <typename Message>
bool Decode(Bytes bytes) {
  const MessageSchemas& schemas = MessageSchemas::Hpdm();
  const LcmStruct* type = schemas.Find(bytes);
  Message message{};
  const bool decoded = DecodeMessage(bytes, &message);
  if (type != nullptr && type->name == std::string("hpdm.") + Message::getTypeName()) {
    // Two decoders, generated and general, agree.
    MessageOrder order;
    const bool readable = schemas.Check(*type, bytes, &order);
    std::size_t values = 0;
    HPDM_ENSURE(readable == schemas.Decode(*type, bytes, [&](const MessageValue&) { ++values; }));
    HPDM_ENSURE(values <= bytes.size());
    HPDM_ENSURE(!decoded || readable);
    HPDM_ENSURE(decoded || !readable || HoldsZeroInString(*type, bytes));
  } else {
    HPDM_ENSURE(!decoded);
  }
  if (!decoded) return false;
  const std::vector<std::uint8_t> again = Encoded(message);
  const bool former = HasFormerHash(bytes, Message::getTypeName());
  const auto body = static_cast<std::ptrdiff_t>(former ? kHashBytes : 0);
  HPDM_ENSURE(std::equal(again.begin() + body, again.end(), bytes.begin() + body, bytes.end()));
  EnsureStays(message, [](const Message& from, Message* to) { return Way(from, to); });
  return true;
}

}  // namespace

bool Message(Bytes bytes) {
  // Tries each type, although at most one can match.
  const bool decoded[] = {Decode<tool_t>(bytes),     Decode<force_t>(bytes),
                          Decode<contact_t>(bytes),  Decode<organ_t>(bytes),
                          Decode<mesh_t>(bytes),     Decode<stats_t>(bytes),
                          Decode<event_t>(bytes),    Decode<device_t>(bytes),
                          Decode<exercise_t>(bytes), Decode<teacher_t>(bytes)};
  return std::count(std::begin(decoded), std::end(decoded), true) == 1;
}

}  // namespace hpdm::fuzz
