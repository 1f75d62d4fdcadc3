#include "tests/fuzz/seeds.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <iterator>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tests/support/scratch_folder.h"

namespace hpdm::fuzz {
namespace {

template <typename Message>
std::vector<std::uint8_t> Bytes(const Message& message) {
  std::vector<std::uint8_t> bytes;
  EncodeMessage(message, &bytes);
  return bytes;
}

HapticSample Tick(int number, int tool_count) {
  HapticSample sample;
  sample.tick = static_cast<std::uint64_t>(number);
  sample.time_ns = number * 1'000'000;
  sample.tool_count = tool_count;
  for (int i = 0; i < tool_count; ++i) {
    ToolSample& tool = sample.tools[static_cast<std::size_t>(i)];
    tool.joints << 0.1, -0.2, 0.15, 1.5, 0.5;
    tool.p_tip_W = {0.01, 0.02, 0.03};
    tool.force_W = {0, 0, 1.5};
    tool.organ = 0;
    tool.kind = ContactKind::kPress;
    tool.device_valid = tool.force_on = true;
  }
  return sample;
}

tool_t ToolMessage(int number, int tool_count) {
  tool_t message{};
  ToMessage(Tick(number, tool_count), &message);
  message.sequence = number + 1;
  return message;
}

force_t ForceMessage(int number, int tool_count) {
  force_t message{};
  ToMessage(Tick(number, tool_count), &message);
  message.sequence = number + 1;
  return message;
}

contact_t ContactMessage(int number, int tool_count) {
  StepSample sample;
  sample.step.number = static_cast<std::uint64_t>(number);
  sample.organ_count = 1;
  sample.organs[0] = {3, false};
  sample.tool_count = tool_count;
  for (int i = 0; i < tool_count; ++i) {
    const Eigen::AngleAxisd rotation(0.3, Vector3d(1, 2, 2) / 3);
    sample.tools[static_cast<std::size_t>(i)].X_WT = Isometry3d(rotation);
    sample.contacts[static_cast<std::size_t>(i)].kind = ContactKind::kPress;
    sample.contacts[static_cast<std::size_t>(i)].organ = 0;
  }
  contact_t message{};
  ToMessage(sample, 34, &message);
  message.sequence = number;
  return message;
}

organ_t OrganMessage() {
  OrganSnapshot shape;
  shape.control_displacements = Points::Constant(4, 3, 0.001);
  shape.local_functions = {7, 12};
  shape.local_displacements = Points::Constant(2, 3, 0.002);
  shape.indentation_count = 1;
  shape.indentations[0].radius = 0.0025;
  shape.indentations[0].resolved_radius = 0.02;
  organ_t message{};
  ToMessage(StepRecord(), 0, shape, &message);
  message.sequence = 1;
  return message;
}

stats_t StatsMessage() {
  stats_t message{};
  message.sequence = 1;
  message.interval_ns = kNanosecondsPerSecond;
  message.bin_count = 2;
  message.bins.resize(2);
  message.bins[1].count = 5;
  return message;
}

event_t EventMessage(std::int64_t sequence, const char* name) {
  event_t message{};
  message.sequence = sequence;
  message.name = name;
  message.text = "said";
  return message;
}

device_t DeviceMessage() {
  DeviceSample sample;
  sample.sequence = 42;
  sample.joints << 0.1, -0.2, 0.15, 1.5, 0.5;
  sample.valid = true;
  device_t message{};
  ToMessage(sample, 1, &message);
  return message;
}

exercise_t ExerciseMessage() {
  exercise_t message{};
  message.sequence = 3;
  message.step = 1;
  message.step_count = 4;
  message.name = "removal";
  message.instruction = "Lift it";
  message.last_error = "dropped";
  return message;
}

teacher_t TeacherMessage() {
  teacher_t message{};
  message.request = teacher_t::POINT;
  message.x = 0.25;
  message.y = 0.75;
  message.text = "here";
  return message;
}

/// A strip of triangles, `rows` squares long.
OrganDescription Strip(int rows) {
  OrganDescription organ;
  organ.name = "strip";
  organ.vertices.resize(2 * rows + 2, 3);
  organ.triangles.resize(2 * rows, 3);
  for (int i = 0; i <= rows; ++i) {
    organ.vertices.row(2 * i) << 0.01 * i, 0, 0;
    organ.vertices.row(2 * i + 1) << 0.01 * i, 0.01, 0;
    if (i == rows) break;
    organ.triangles.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    organ.triangles.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  return organ;
}

OrganDescription StripInLattice(int rows) {
  OrganDescription organ = Strip(rows);
  LatticeDescription& lattice = organ.lattice.emplace();
  lattice.lengths = {1, 0.1, 0.1};
  for (int i = 0; i < 20; ++i) lattice.kept.push_back(3 * i);
  return organ;
}

std::vector<std::uint8_t> PartsOf(const OrganDescription& organ) {
  std::vector<std::uint8_t> bytes;
  for (const mesh_t& part : SplitMesh(0, organ, 2000)) {
    const std::vector<std::uint8_t> encoded = Bytes(part);
    bytes.push_back(static_cast<std::uint8_t>(encoded.size() & 255));
    bytes.push_back(static_cast<std::uint8_t>(encoded.size() >> 8));
    bytes.insert(bytes.end(), encoded.begin(), encoded.end());
  }
  return bytes;
}

/// A closed session of three ticks and two steps.
std::vector<std::uint8_t> SessionBytes() {
  const ScratchFolder folder;
  const std::string path = folder / "session.lcmlog";
  {
    SessionLog log(path, 0);
    const auto write = [&log](const char* channel, Nanoseconds time, const auto& message) {
      log.Write(channel, time, Bytes(message));
    };
    write(kEventChannel, 0, EventMessage(1, "session.start"));
    write(kMeshChannel, 0, SplitMesh(0, Strip(1))[0]);
    for (int tick = 0; tick < 3; ++tick) {
      const Nanoseconds time = tick * 1'000'000;
      write(kToolChannel, time, ToolMessage(tick, 1));
      write(kForceChannel, time, ForceMessage(tick, 1));
      if (tick > 0) write(kContactChannel, time, ContactMessage(tick, 0));
    }
    write(kDeviceChannel, 2'000'000, DeviceMessage());
    write(kEventChannel, 3'000'000, EventMessage(2, "session.end"));
  }
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Damage in the middle and a torn tail.
std::vector<std::uint8_t> DamagedSessionBytes() {
  std::vector<std::uint8_t> bytes = SessionBytes();
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2), 9, std::uint8_t{0xED});
  bytes.resize(bytes.size() - 7);
  return bytes;
}

constexpr float kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
constexpr int kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

/// A number's bytes, `big`: the high one first.
template <typename Number>
void Append(Number number, bool big, std::vector<std::uint8_t>* bytes) {
  std::array<std::uint8_t, sizeof(Number)> raw;
  std::memcpy(raw.data(), &number, sizeof(Number));
  if (big) std::reverse(raw.begin(), raw.end());
  bytes->insert(bytes->end(), raw.begin(), raw.end());
}

std::vector<std::uint8_t> BinaryStl() {
  std::vector<std::uint8_t> bytes(80);
  Append(std::uint32_t{4}, false, &bytes);
  for (const auto& face : kFaces) {
    bytes.resize(bytes.size() + 12);  // the normal
    for (const int corner : face) {
      for (const float x : kCorners[corner]) Append(x, false, &bytes);
    }
    bytes.resize(bytes.size() + 2);
  }
  return bytes;
}

std::vector<std::uint8_t> BinaryPly(bool big) {
  const std::string header =
      std::string("ply\nformat binary_") + (big ? "big" : "little") +
      "_endian 1.0\ncomment a\nelement vertex 4\nproperty double x\nproperty float y\n"
      "property float z\nproperty float s\nproperty float t\nproperty uchar red\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  for (const auto& corner : kCorners) {
    Append(static_cast<double>(corner[0]), big, &bytes);
    for (const float value : {corner[1], corner[2], 0.25f, 0.75f}) Append(value, big, &bytes);
    bytes.push_back(200);
  }
  for (const auto& face : kFaces) {
    bytes.push_back(3);
    for (const int corner : face) Append(corner, big, &bytes);
  }
  return bytes;
}

}  // namespace

std::vector<Seed> BinarySeeds() {
  return {{"LogFile", "session", SessionBytes()},
          {"LogFile", "damaged", DamagedSessionBytes()},
          {"MeshParts", "strip", PartsOf(StripInLattice(60))},
          {"MeshParts", "no_lattice", PartsOf(Strip(3))},
          {"MeshPly", "little_endian.ply", BinaryPly(false)},
          {"MeshPly", "big_endian.ply", BinaryPly(true)},
          {"MeshStl", "binary.stl", BinaryStl()},
          {"Message", "tool_t", Bytes(ToolMessage(1, 2))},
          {"Message", "force_t", Bytes(ForceMessage(1, 2))},
          {"Message", "contact_t", Bytes(ContactMessage(1, 2))},
          {"Message", "organ_t", Bytes(OrganMessage())},
          {"Message", "mesh_t", Bytes(SplitMesh(0, StripInLattice(3))[0])},
          {"Message", "stats_t", Bytes(StatsMessage())},
          {"Message", "event_t", Bytes(EventMessage(1, "session.start"))},
          {"Message", "device_t", Bytes(DeviceMessage())},
          {"Message", "exercise_t", Bytes(ExerciseMessage())},
          {"Message", "teacher_t", Bytes(TeacherMessage())}};
}

}  // namespace hpdm::fuzz
