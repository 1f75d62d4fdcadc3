#include "lcmtypes/wire/codec.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "lcmtypes/wire/message_hash.h"
#include "lcmtypes/wire/sample_fields.h"

namespace hpdm {
namespace {

constexpr std::size_t kCountBytes = 4;

Vector3d ToVector(const double (&from)[3]) { return {from[0], from[1], from[2]}; }

std::int64_t Signed(std::uint64_t number) { return static_cast<std::int64_t>(number); }
std::uint64_t Unsigned(std::int64_t number) { return static_cast<std::uint64_t>(number); }

/// Copies a value of a sample into a message, and back.
template <typename Value, typename Wire>
requires(!std::is_class_v<Value>) void Copy(Value from, Wire& to) { to = static_cast<Wire>(from); }
template <typename Vector, std::size_t kSize>
void Copy(const Vector& from, double (&to)[kSize]) {
  static_assert(Vector::SizeAtCompileTime == kSize);
  std::copy_n(from.data(), kSize, to);
}
template <typename Vector, std::size_t kSize>
void Copy(const double (&from)[kSize], Vector& to) {
  to = Eigen::Map<const Vector>(from);
}
void Copy(const Matrix3d& from, double (&to)[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to[i][j] = from(i, j);
  }
}
void Copy(const double (&from)[3][3], Matrix3d& to) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to(i, j) = from[i][j];
  }
}

template <typename Fields, typename Sample, typename Message>
void ToMessage(const Fields& fields, const Sample& sample, Message* message) {
  VisitFields(fields,
              [&](const auto& field) { Copy(sample.*field.sample, message->*field.message); });
}

template <typename Wire>
bool Contains(const FieldRange& range, const Wire& value) {
  if constexpr (std::is_arithmetic_v<Wire>) {
    const auto number = static_cast<double>(value);
    return number >= range.min && number <= range.max;
  }
  return true;  // arrays have no range
}

/// False if a value is out of its field's range.
template <typename Fields, typename Message, typename Sample>
bool FromMessage(const Fields& fields, const Message& message, Sample* sample) {
  bool valid = true;
  VisitFields(fields, [&](const auto& field) {
    valid = valid && (!field.range || Contains(*field.range, message.*field.message));
    Copy(message.*field.message, sample->*field.sample);
  });
  return valid;
}

/// True if an array has as many elements as its message states, at most `max`.
template <typename Element>
bool HasCount(int count, int max, const std::vector<Element>& elements) {
  return count >= 0 && count <= max && static_cast<std::size_t>(count) == elements.size();
}

void ToMessage(const Isometry3d& X_WT, tool_contact_t* message) {
  const Vector3d p_tip_W = X_WT.translation();
  const Eigen::Quaterniond rotation(X_WT.linear());
  Copy(p_tip_W, message->p_tip);
  message->orientation[0] = rotation.w();
  message->orientation[1] = rotation.x();
  message->orientation[2] = rotation.y();
  message->orientation[3] = rotation.z();
}

bool FromMessage(const tool_contact_t& message, Isometry3d* X_WT) {
  const auto& [w, x, y, z] = message.orientation;
  const Eigen::Quaterniond rotation(w, x, y, z);
  *X_WT = Isometry3d::Identity();
  X_WT->linear() = rotation.toRotationMatrix();
  X_WT->translation() = ToVector(message.p_tip);
  // False also for NaN; a rounding away from 1 is some 1e-16.
  return std::abs(rotation.squaredNorm() - 1) < 1e-9;
}

std::int32_t ReadBigEndian(const std::uint8_t* bytes) {
  return static_cast<std::int32_t>(std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
                                   std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]});
}

}  // namespace

void ToMessage(const HapticSample& sample, tool_t* message) {
  ToMessage(logged::kTickInput, sample, message);
  ToMessage(logged::kRestart, sample.restart, message);
  ToMessage(logged::kSkipped, sample.skipped, message);
  message->tool_count = sample.tool_count;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    ToMessage(logged::kToolInput, sample.tools[i], &message->tools[i]);
  }
}

bool FromMessage(const tool_t& message, HapticSample* sample) {
  if (!HasCount(message.tool_count, kMaxInstruments, message.tools)) return false;
  sample->tool_count = message.tool_count;
  bool valid = FromMessage(logged::kTickInput, message, sample) &&
               FromMessage(logged::kRestart, message, &sample->restart) &&
               FromMessage(logged::kSkipped, message, &sample->skipped);
  for (int i = 0; i < message.tool_count; ++i) {
    valid = valid && FromMessage(logged::kToolInput, message.tools[i], &sample->tools[i]);
  }
  return valid;
}

void ToMessage(const HapticSample& sample, force_t* message) {
  ToMessage(logged::kTickOutput, sample, message);
  message->tool_count = sample.tool_count;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    ToMessage(logged::kToolOutput, sample.tools[i], &message->tools[i]);
  }
}

bool FromMessage(const force_t& message, HapticSample* sample) {
  if (!HasCount(message.tool_count, kMaxInstruments, message.tools)) return false;
  sample->tool_count = message.tool_count;
  bool valid = FromMessage(logged::kTickOutput, message, sample);
  for (int i = 0; i < message.tool_count; ++i) {
    valid = valid && FromMessage(logged::kToolOutput, message.tools[i], &sample->tools[i]);
  }
  return valid;
}

void ToMessage(const StepSample& sample, std::int64_t visible_tick, contact_t* message) {
  ToMessage(logged::kStep, sample.step, message);
  ToMessage(logged::kResidual, sample.step, message);
  message->visible_tick = visible_tick;
  message->organ_count = sample.organ_count;
  message->organs.resize(sample.organ_count);
  for (int o = 0; o < sample.organ_count; ++o) {
    ToMessage(logged::kRelaxation, sample.organs[o], &message->organs[o]);
  }
  message->attachment_count = sample.attachment_count;
  message->attachments.resize(static_cast<std::size_t>(sample.attachment_count));
  for (int a = 0; a < sample.attachment_count; ++a) {
    ToMessage(logged::kAttachment, sample.attachments[a], &message->attachments[a]);
  }
  message->duct_count = sample.duct_count;
  message->ducts.resize(static_cast<std::size_t>(sample.duct_count));
  for (int d = 0; d < sample.duct_count; ++d) {
    ToMessage(logged::kDuct, sample.ducts[d], &message->ducts[d]);
  }
  message->tool_count = sample.tool_count;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    tool_contact_t* const tool = &message->tools[i];
    ToMessage(sample.tools[i].X_WT, tool);
    ToMessage(logged::kPose, sample.tools[i], tool);
    ToMessage(logged::kContact, sample.contacts[i], tool);
    ToMessage(logged::kLayerWork, sample.layer_work[i], tool);
    ToMessage(logged::kDuctAction, sample.duct_actions[i], tool);
    ToMessage(logged::kNearDuct, sample.near_ducts[i], tool);
    for (std::size_t b = 0; b < sample.beside[i].size(); ++b) {
      ToMessage(logged::kBeside, sample.beside[i][b], &tool->beside[b]);
    }
  }
}

bool FromMessage(const contact_t& message, StepSample* sample, std::int64_t* visible_tick) {
  if (!HasCount(message.tool_count, kMaxInstruments, message.tools) ||
      !HasCount(message.organ_count, kMaxOrgans, message.organs) ||
      !HasCount(message.attachment_count, kMaxAttachments, message.attachments) ||
      !HasCount(message.duct_count, kMaxDucts, message.ducts)) {
    return false;
  }
  *visible_tick = message.visible_tick;
  bool valid = FromMessage(logged::kStep, message, &sample->step) &&
               FromMessage(logged::kResidual, message, &sample->step);
  sample->organ_count = message.organ_count;
  for (int o = 0; o < message.organ_count; ++o) {
    sample->organs[o] = {};
    valid = valid && FromMessage(logged::kRelaxation, message.organs[o], &sample->organs[o]);
  }
  sample->attachment_count = message.attachment_count;
  for (int a = 0; a < message.attachment_count; ++a) {
    valid =
        valid && FromMessage(logged::kAttachment, message.attachments[a], &sample->attachments[a]);
  }
  sample->duct_count = message.duct_count;
  for (int d = 0; d < message.duct_count; ++d) {
    valid = valid && FromMessage(logged::kDuct, message.ducts[d], &sample->ducts[d]);
  }
  sample->tool_count = message.tool_count;
  for (int i = 0; i < message.tool_count; ++i) {
    const tool_contact_t& tool = message.tools[i];
    valid = valid && FromMessage(tool, &sample->tools[i].X_WT) &&
            FromMessage(logged::kPose, tool, &sample->tools[i]) &&
            FromMessage(logged::kContact, tool, &sample->contacts[i]) &&
            FromMessage(logged::kLayerWork, tool, &sample->layer_work[i]) &&
            FromMessage(logged::kDuctAction, tool, &sample->duct_actions[i]) &&
            FromMessage(logged::kNearDuct, tool, &sample->near_ducts[i]);
    for (std::size_t b = 0; b < sample->beside[i].size(); ++b) {
      sample->beside[i][b] = {};
      sample->beside[i][b].kind =
          tool.beside[b].organ < 0 ? ContactKind::kNone : ContactKind::kPress;
      valid = valid && FromMessage(logged::kBeside, tool.beside[b], &sample->beside[i][b]);
    }
  }
  return valid;
}

void ToMessage(const StepRecord& step, int organ, const OrganSnapshot& shape, organ_t* message) {
  message->step = Signed(step.number);
  message->time_ns = step.time_ns;
  message->organ = organ;
  Copy(shape.offset_W, message->offset);
  const Points& displacements = shape.control_displacements;
  message->value_count = static_cast<std::int32_t>(displacements.size());
  message->displacements.assign(displacements.data(), displacements.data() + displacements.size());
  message->local_functions.clear();
  message->local_displacements.clear();
  for (std::size_t slot = 0; slot < shape.local_functions.size(); ++slot) {
    if (shape.local_functions[slot] < 0) continue;
    message->local_functions.push_back(shape.local_functions[slot]);
    for (int d = 0; d < 3; ++d) {
      const auto row = static_cast<Eigen::Index>(slot);
      message->local_displacements.push_back(static_cast<float>(shape.local_displacements(row, d)));
    }
  }
  message->local_count = static_cast<std::int32_t>(message->local_functions.size());
  message->local_value_count = static_cast<std::int32_t>(message->local_displacements.size());
  message->indentation_count = shape.indentation_count;
  message->indentations.resize(shape.indentation_count);
  for (int i = 0; i < shape.indentation_count; ++i) {
    const IndentationSnapshot& from = shape.indentations[i];
    indentation_t& to = message->indentations[i];
    Copy(from.p_rest_W, to.centre);
    Copy(from.normal_W, to.normal);
    Copy(from.amplitude_W, to.amplitude);
    to.radius = from.radius;
    to.resolved_radius = from.resolved_radius;
  }
}

bool FromMessage(const organ_t& message, OrganSnapshot* shape) {
  if (!HasCount(message.value_count, INT32_MAX, message.displacements) ||
      !HasCount(message.local_count, INT32_MAX, message.local_functions) ||
      !HasCount(message.local_value_count, INT32_MAX, message.local_displacements) ||
      !HasCount(message.indentation_count, kMaxInstruments, message.indentations) ||
      message.displacements.size() % 3 != 0 ||
      message.local_displacements.size() != 3 * message.local_functions.size() ||
      message.organ < 0) {
    return false;
  }
  const auto take = [](const std::vector<float>& values, Points* points) {
    points->resize(static_cast<Eigen::Index>(values.size() / 3), 3);
    std::copy(values.begin(), values.end(), points->data());
  };
  take(message.displacements, &shape->control_displacements);
  take(message.local_displacements, &shape->local_displacements);
  shape->offset_W = ToVector(message.offset);
  shape->local_functions = message.local_functions;
  shape->indentation_count = message.indentation_count;
  for (int i = 0; i < message.indentation_count; ++i) {
    const indentation_t& from = message.indentations[i];
    IndentationSnapshot& to = shape->indentations[i];
    if (!(from.radius > 0) || !(from.resolved_radius >= from.radius)) return false;
    to = {Eigen::Map<const Vector3d>(from.centre), Eigen::Map<const Vector3d>(from.normal),
          from.radius, from.resolved_radius, Eigen::Map<const Vector3d>(from.amplitude)};
  }
  return true;
}

void ToMessage(const DeviceSample& sample, int instrument, device_t* message) {
  message->sequence = Signed(sample.sequence);
  message->time_ns = sample.time_ns;
  message->instrument = instrument;
  Copy(sample.joints, message->joints);
  message->valid = sample.valid;
  message->pedal = sample.pedal;
}

bool FromMessage(const device_t& message, DeviceSample* sample, int* instrument) {
  if (message.instrument < 0 || message.instrument >= kMaxInstruments) return false;
  *instrument = message.instrument;
  sample->sequence = Unsigned(message.sequence);
  sample->time_ns = message.time_ns;
  sample->joints = Eigen::Map<const JointVector>(message.joints);
  sample->valid = message.valid != 0;
  sample->pedal = message.pedal != 0;
  return true;
}

bool CountsFit(std::span<const std::uint8_t> bytes, std::span<const int> element_sizes) {
  if (bytes.size() < kHashBytes + kCountBytes * element_sizes.size()) return false;
  std::int64_t wanted = 0;
  for (std::size_t i = 0; i < element_sizes.size(); ++i) {
    const std::int64_t count = ReadBigEndian(bytes.data() + kHashBytes + kCountBytes * i);
    if (count < 0) return false;
    wanted += count * element_sizes[i];
  }
  return wanted <= static_cast<std::int64_t>(bytes.size());
}

bool StringsFit(std::span<const std::uint8_t> bytes, StringPlace place) {
  std::size_t at = place.begin;
  for (int i = 0; i < place.count; ++i) {
    if (bytes.size() < at + kCountBytes) return false;
    const std::int32_t length = ReadBigEndian(bytes.data() + at);  // with the final zero
    at += kCountBytes;
    if (length < 1 || static_cast<std::size_t>(length) > bytes.size() - at) return false;
    const auto string = bytes.subspan(at, static_cast<std::size_t>(length));
    if (std::find(string.begin(), string.end(), 0) != string.end() - 1) return false;
    at += string.size();
  }
  return true;
}

// What precedes them: the hash and fixed members.
StringPlace StringsOf(const event_t&) { return {kHashBytes + 8 + 8 + 1, 2}; }
StringPlace StringsOf(const mesh_t&) { return {kHashBytes + 3 * 4 + 8 + 3 * 4, 1}; }
StringPlace StringsOf(const exercise_t&) { return {kHashBytes + 2 * 8 + 4 * 4 + 5 * 8 + 2, 3}; }
StringPlace StringsOf(const teacher_t&) { return {kHashBytes + 8 + 1 + 4 + 2 * 8, 1}; }

std::span<const int> ElementSizes(const tool_t&) {
  static const int sizes[] = {tool_input_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const force_t&) {
  static const int sizes[] = {tool_force_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const contact_t&) {
  static const int sizes[] = {
      tool_contact_t()._getEncodedSizeNoHash(), organ_relaxation_t()._getEncodedSizeNoHash(),
      attachment_outcome_t()._getEncodedSizeNoHash(), duct_outcome_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const organ_t&) {
  static const int sizes[] = {4, 4, 4, indentation_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const mesh_t&) {
  static const int sizes[] = {4, 4, 4};
  return sizes;
}
std::span<const int> ElementSizes(const stats_t&) {
  static const int sizes[] = {bin_t()._getEncodedSizeNoHash()};
  return sizes;
}

}  // namespace hpdm
