#include "lcmtypes/wire/codec.h"

#include <algorithm>
#include <cmath>

#include "lcmtypes/wire/message_hash.h"

namespace hpdm {
namespace {

constexpr std::size_t kCountBytes = 4;

template <typename Vector>
void Copy(const Vector& from, double* to) {
  std::copy(from.data(), from.data() + from.size(), to);
}

Vector3d ToVector(const double (&from)[3]) { return {from[0], from[1], from[2]}; }

// A number beyond what a scene can hold comes from no sender of ours.
bool IsInstrumentIndex(int index) { return index >= 0 && index < kMaxHeld; }

bool IsKind(int kind) { return kind >= 0 && kind <= static_cast<int>(ContactKind::kGrasp); }

bool IsShare(double share) { return share >= 0 && share <= 1; }

bool IsToolCount(int count, std::size_t held) {
  return count >= 0 && count <= kMaxInstruments && static_cast<std::size_t>(count) == held;
}

void Copy(const Matrix3d& from, double (&to)[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to[i][j] = from(i, j);
  }
}

Matrix3d ToMatrix(const double (&from)[3][3]) {
  Matrix3d to;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to(i, j) = from[i][j];
  }
  return to;
}

std::int64_t Signed(std::uint64_t number) { return static_cast<std::int64_t>(number); }
std::uint64_t Unsigned(std::int64_t number) { return static_cast<std::uint64_t>(number); }

std::int32_t ReadBigEndian(const std::uint8_t* bytes) {
  return static_cast<std::int32_t>(std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
                                   std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]});
}

}  // namespace

void ToMessage(const HapticSample& sample, tool_t* message) {
  message->tool_count = sample.tool_count;
  message->tick = Signed(sample.tick);
  message->time_ns = sample.time_ns;
  message->device_time_ns = sample.device_time_ns;
  message->wake_late_ns = sample.wake_late_ns;
  message->skipped_late_wake_up = static_cast<std::int32_t>(sample.skipped.late_wake_up);
  message->skipped_long_compute = static_cast<std::int32_t>(sample.skipped.long_compute);
  message->skipped_stalled = static_cast<std::int32_t>(sample.skipped.stalled);
  message->paused = sample.paused;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& from = sample.tools[i];
    tool_input_t& to = message->tools[i];
    Copy(from.joints, to.joints);
    Copy(from.p_tip_W, to.p_tip);
    Copy(from.v_tip_W, to.v_tip);
    to.device_time_ns = from.device_time_ns;
    to.force_on = from.force_on;
    to.device_valid = from.device_valid;
    to.instrument_index = from.instrument_index;
  }
}

bool FromMessage(const tool_t& message, HapticSample* sample) {
  if (!IsToolCount(message.tool_count, message.tools.size())) return false;
  sample->tool_count = message.tool_count;
  sample->tick = Unsigned(message.tick);
  sample->time_ns = message.time_ns;
  sample->device_time_ns = message.device_time_ns;
  sample->wake_late_ns = message.wake_late_ns;
  sample->skipped.late_wake_up = static_cast<std::uint32_t>(message.skipped_late_wake_up);
  sample->skipped.long_compute = static_cast<std::uint32_t>(message.skipped_long_compute);
  sample->skipped.stalled = static_cast<std::uint32_t>(message.skipped_stalled);
  sample->paused = message.paused != 0;
  for (int i = 0; i < message.tool_count; ++i) {
    const tool_input_t& from = message.tools[i];
    if (!IsInstrumentIndex(from.instrument_index)) return false;
    ToolSample& to = sample->tools[i];
    to.joints = Eigen::Map<const JointVector>(from.joints);
    to.p_tip_W = ToVector(from.p_tip);
    to.v_tip_W = ToVector(from.v_tip);
    to.device_time_ns = from.device_time_ns;
    to.force_on = from.force_on != 0;
    to.device_valid = from.device_valid != 0;
    to.instrument_index = from.instrument_index;
  }
  return true;
}

void ToMessage(const HapticSample& sample, force_t* message) {
  message->tool_count = sample.tool_count;
  message->tick = Signed(sample.tick);
  message->time_ns = sample.time_ns;
  message->patch_number = Signed(sample.patch_number);
  message->patch_age_ns = sample.patch_age_ns;
  message->written_ns = sample.written_ns;
  message->compute_ns = sample.compute_ns;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolSample& from = sample.tools[i];
    tool_force_t& to = message->tools[i];
    Copy(from.reaction_W, to.reaction);
    Copy(from.force_W, to.force);
    Copy(from.effort, to.effort);
    to.depth = from.depth;
    to.organ = from.organ;
    to.kind = static_cast<std::int8_t>(from.kind);
    to.energy = from.energy;
    to.damping = from.damping;
    to.guard_flags = static_cast<std::int32_t>(from.guard_flags);
  }
}

bool FromMessage(const force_t& message, HapticSample* sample) {
  if (!IsToolCount(message.tool_count, message.tools.size())) return false;
  sample->tool_count = message.tool_count;
  sample->tick = Unsigned(message.tick);
  sample->time_ns = message.time_ns;
  sample->patch_number = Unsigned(message.patch_number);
  sample->patch_age_ns = message.patch_age_ns;
  sample->written_ns = message.written_ns;
  sample->compute_ns = message.compute_ns;
  for (int i = 0; i < message.tool_count; ++i) {
    const tool_force_t& from = message.tools[i];
    if (!IsKind(from.kind)) return false;
    ToolSample& to = sample->tools[i];
    to.reaction_W = ToVector(from.reaction);
    to.force_W = ToVector(from.force);
    to.effort = ToVector(from.effort);
    to.depth = from.depth;
    to.organ = from.organ;
    to.kind = static_cast<ContactKind>(from.kind);
    to.energy = from.energy;
    to.damping = from.damping;
    to.guard_flags = static_cast<std::uint32_t>(from.guard_flags);
  }
  return true;
}

void ToMessage(const StepSample& sample, std::int64_t visible_tick, contact_t* message) {
  const StepRecord& step = sample.step;
  message->organ_count = sample.organ_count;
  message->organs.resize(sample.organ_count);
  for (int o = 0; o < sample.organ_count; ++o) {
    message->organs[o].iterations = sample.organs[o].iterations;
    message->organs[o].out_of_time = sample.organs[o].out_of_time;
    message->organs[o].finite_strain_blend = sample.organs[o].finite_strain_blend;
    message->organs[o].refinement_weight = sample.organs[o].refinement_weight;
  }
  message->tool_count = sample.tool_count;
  message->step = Signed(step.number);
  message->input_tick = Signed(step.input_tick);
  message->visible_tick = visible_tick;
  message->time_ns = step.time_ns;
  message->device_time_ns = step.device_time_ns;
  message->wake_late_ns = step.wake_late_ns;
  message->compute_ns = step.compute_ns;
  message->iterations = step.iterations;
  message->residual = step.residual;
  message->flags = static_cast<std::int32_t>(step.flags);
  message->shed_level = step.shed_level;
  message->tools.resize(sample.tool_count);
  for (int i = 0; i < sample.tool_count; ++i) {
    const ToolPose& pose = sample.tools[i];
    const SolvedContact& contact = sample.contacts[i];
    tool_contact_t& to = message->tools[i];
    const Vector3d p_tip_W = pose.X_WT.translation();
    const Eigen::Quaterniond rotation(pose.X_WT.linear());
    Copy(p_tip_W, to.p_tip);
    to.orientation[0] = rotation.w();
    to.orientation[1] = rotation.x();
    to.orientation[2] = rotation.y();
    to.orientation[3] = rotation.z();
    Copy(pose.p_trocar_W, to.p_trocar);
    Copy(pose.v_tip_W, to.v_tip);
    to.jaw = pose.jaw;
    to.instrument_index = pose.instrument_index;
    to.organ = contact.organ;
    to.kind = static_cast<std::int8_t>(contact.kind);
    Copy(contact.contact_W, to.p_contact);
    Copy(contact.force_on_tissue_W, to.force_on_tissue);
    to.shaft_contact = contact.shaft_contact;
    to.reaction = static_cast<std::int8_t>(contact.reaction);
    Copy(contact.p_original_W, to.p_original);
    Copy(contact.normal_W, to.normal);
    Copy(contact.compliance_W, to.compliance);
    Copy(contact.coupling_W, to.coupling);
    to.kernel_radius = contact.kernel_radius;
  }
}

bool FromMessage(const contact_t& message, StepSample* sample, std::int64_t* visible_tick) {
  if (!IsToolCount(message.tool_count, message.tools.size())) return false;
  if (message.organ_count < 0 || message.organ_count > kMaxOrgans ||
      static_cast<std::size_t>(message.organ_count) != message.organs.size()) {
    return false;
  }
  sample->organ_count = message.organ_count;
  for (int o = 0; o < message.organ_count; ++o) {
    const organ_relaxation_t& from = message.organs[o];
    if (from.iterations < 0 || !IsShare(from.finite_strain_blend) ||
        !IsShare(from.refinement_weight)) {
      return false;
    }
    OrganRelaxation& organ = sample->organs[o];
    organ = {};
    organ.iterations = from.iterations;
    organ.out_of_time = from.out_of_time != 0;
    organ.finite_strain_blend = from.finite_strain_blend;
    organ.refinement_weight = from.refinement_weight;
  }
  sample->tool_count = message.tool_count;
  *visible_tick = message.visible_tick;
  StepRecord& step = sample->step;
  step.number = Unsigned(message.step);
  step.input_tick = Unsigned(message.input_tick);
  step.time_ns = message.time_ns;
  step.device_time_ns = message.device_time_ns;
  step.wake_late_ns = message.wake_late_ns;
  step.compute_ns = message.compute_ns;
  step.iterations = message.iterations;
  step.residual = message.residual;
  step.flags = static_cast<std::uint32_t>(message.flags);
  step.shed_level = message.shed_level;
  for (int i = 0; i < message.tool_count; ++i) {
    const tool_contact_t& from = message.tools[i];
    if (!IsKind(from.kind) || !IsInstrumentIndex(from.instrument_index)) return false;
    if (from.reaction < 0 || from.reaction > 1) return false;
    ToolPose& pose = sample->tools[i];
    SolvedContact& contact = sample->contacts[i];
    const Eigen::Quaterniond rotation(from.orientation[0], from.orientation[1], from.orientation[2],
                                      from.orientation[3]);
    // Written so that NaN is refused too; a rounding away from 1 is some 1e-16.
    if (!(std::abs(rotation.squaredNorm() - 1) < 1e-9)) return false;
    pose.X_WT = Isometry3d::Identity();
    pose.X_WT.linear() = rotation.toRotationMatrix();
    pose.X_WT.translation() = ToVector(from.p_tip);
    pose.p_trocar_W = ToVector(from.p_trocar);
    pose.v_tip_W = ToVector(from.v_tip);
    pose.jaw = from.jaw;
    pose.instrument_index = from.instrument_index;
    contact.organ = from.organ;
    contact.kind = static_cast<ContactKind>(from.kind);
    contact.contact_W = ToVector(from.p_contact);
    contact.force_on_tissue_W = ToVector(from.force_on_tissue);
    contact.shaft_contact = from.shaft_contact != 0;
    contact.reaction = static_cast<ReactionType>(from.reaction);
    contact.p_original_W = ToVector(from.p_original);
    contact.normal_W = ToVector(from.normal);
    contact.compliance_W = ToMatrix(from.compliance);
    contact.coupling_W = ToMatrix(from.coupling);
    contact.kernel_radius = from.kernel_radius;
  }
  return true;
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
  const auto holds = [](std::int32_t count, const auto& array) {
    return count >= 0 && static_cast<std::size_t>(count) == array.size();
  };
  if (!holds(message.value_count, message.displacements) ||
      !holds(message.local_count, message.local_functions) ||
      !holds(message.local_value_count, message.local_displacements) ||
      !holds(message.indentation_count, message.indentations) || message.value_count % 3 != 0 ||
      message.displacements.size() % 3 != 0 ||
      message.local_displacements.size() != 3 * message.local_functions.size() ||
      message.indentation_count > kMaxInstruments || message.organ < 0) {
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
}

bool FromMessage(const device_t& message, DeviceSample* sample, int* instrument) {
  if (message.instrument < 0 || message.instrument >= kMaxInstruments) return false;
  *instrument = message.instrument;
  sample->sequence = Unsigned(message.sequence);
  sample->time_ns = message.time_ns;
  sample->joints = Eigen::Map<const JointVector>(message.joints);
  sample->valid = message.valid != 0;
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

std::span<const int> ElementSizes(const tool_t&) {
  static const int sizes[] = {tool_input_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const force_t&) {
  static const int sizes[] = {tool_force_t()._getEncodedSizeNoHash()};
  return sizes;
}
std::span<const int> ElementSizes(const contact_t&) {
  static const int sizes[] = {tool_contact_t()._getEncodedSizeNoHash(),
                              organ_relaxation_t()._getEncodedSizeNoHash()};
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
