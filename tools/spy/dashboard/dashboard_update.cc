#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string_view>

#include "engine/base/text_list.h"
#include "engine/contact/half_space.h"
#include "tools/shared/base64.h"
#include "tools/spy/dashboard/dashboard_state.h"

/// The part of DashboardState that writes updates for the pages as JSON. It changes only the Seen
/// of a viewer and the cached JSON of shapes.

namespace hpdm {
namespace {

using nlohmann::json;

constexpr std::chrono::seconds kChannelsEvery{1};
constexpr int kSinkingIntervals = 256;
constexpr double kSinkingEnd = 3;

// Text from messages may not be UTF-8.
std::string Text(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void AddMember(const char* name, const std::string& value, std::string* members) {
  if (!members->empty()) *members += ',';
  *members += '"';
  *members += name;
  *members += "\":";
  *members += value;
}

json Vector(const double* v) { return {v[0], v[1], v[2]}; }

// True if the shape belongs to the mesh: it has as many displacements as the mesh has control
// points or vertices.
bool Fits(const organ_t& shape, const OrganDescription& mesh) {
  const std::size_t n = shape.displacements.size() / 3;
  if (!mesh.lattice) return n == 0 || n == static_cast<std::size_t>(mesh.vertices.rows());
  return n == mesh.lattice->kept.size();
}

// The page (tools/web/src/ffd.js) names the amplitude "strength" and the indentations "dents".
json IndentationJson(const indentation_t& indentation) {
  return {{"centre", Vector(indentation.centre)},
          {"normal", Vector(indentation.normal)},
          {"radius", indentation.radius},
          {"resolved_radius", indentation.resolved_radius},
          {"strength", Vector(indentation.amplitude)}};
}

json LoopJson(const loop_stats_t& loop, std::int64_t missed) {
  return {{"rate_hz", loop.rate_hz}, {"cycles", loop.cycles}, {"missed", missed}};
}

// Returns the half-space sinking (half_space.h) at even steps up to `end` radii. `tail` is the
// second coefficient of the series beyond: sinking(end) pi end^3 - end^2.
std::string SinkingJson() {
  std::array<double, kSinkingIntervals + 1> values;
  for (int i = 0; i <= kSinkingIntervals; ++i) {
    values[i] = KernelSinking(i * kSinkingEnd / kSinkingIntervals);
  }
  const double tail =
      (values.back() * std::numbers::pi * kSinkingEnd - 1) * kSinkingEnd * kSinkingEnd;
  return Text({{"end", kSinkingEnd}, {"values", Base64Of(values)}, {"tail", tail}});
}

}  // namespace

const std::string& DashboardState::ShapeJson(int number) {
  Organ& organ = organs_.at(number);
  if (organ.shape_json_version == organ.shape_version) return organ.shape_json;
  json value = {{"organ", number}};
  if (organ.shape && organ.mesh.whole()) {
    const organ_t& shape = *organ.shape;
    value["fits"] = Fits(shape, *organ.mesh.whole());
    value["step"] = shape.step;
    value["offset"] = Vector(shape.offset);
    value["displacements"] = Base64Of(shape.displacements);
    value["local_functions"] = Base64Of(shape.local_functions);
    value["local_displacements"] = Base64Of(shape.local_displacements);
    value["dents"] = json::array();
    for (const indentation_t& indentation : shape.indentations) {
      value["dents"].push_back(IndentationJson(indentation));
    }
  }
  organ.shape_json = Text(value);
  organ.shape_json_version = organ.shape_version;
  return organ.shape_json;
}

// Restarts a viewer that has seen another generation; it keeps its meshes and names.
void DashboardState::AddReset(Seen* seen, std::string* members) const {
  if (seen->generation == generation_) return;
  const bool first = seen->generation == 0;
  Seen restarted;
  restarted.generation = generation_;
  restarted.meshes = seen->meshes;
  restarted.names = seen->names;
  *seen = restarted;
  json present = json::array();
  for (const auto& [number, organ] : organs_) present.push_back(number);
  AddMember("reset", Text({{"organs", present}}), members);
  if (first) AddMember("sinking", SinkingJson(), members);
}

void DashboardState::AddOrgans(Seen* seen, std::string* members) {
  std::string meshes, shapes;
  for (auto& [number, organ] : organs_) {
    if (organ.mesh_version == 0) continue;
    std::uint64_t& mesh_seen = seen->meshes[number];
    std::uint64_t& shape_seen = seen->shapes[number];
    if (mesh_seen != organ.mesh_version) {
      mesh_seen = organ.mesh_version;
      shape_seen = 0;
      organ.shape_json_version = 0;  // the shape may no longer fit the mesh
      const std::string& name = organ.mesh.whole()->name;
      AppendToList(Text({{"organ", number}, {"version", mesh_seen}, {"name", name}}), &meshes, ",");
    }
    if (shape_seen != organ.shape_version) {
      shape_seen = organ.shape_version;
      AppendToList(ShapeJson(number), &shapes, ",");
    }
  }
  if (!meshes.empty()) AddMember("meshes", "[" + meshes + "]", members);
  if (!shapes.empty()) AddMember("organs", "[" + shapes + "]", members);
}

void DashboardState::AddRows(Seen* seen, std::string* members) const {
  const std::uint64_t rows_end = trace_.first_row() + trace_.rows().size();
  if (seen->row == rows_end) return;
  json rows = json::array();
  for (std::uint64_t r = std::max(seen->row, trace_.first_row()); r < rows_end; ++r) {
    const ForceTrace::Row& row = trace_.rows()[r - trace_.first_row()];
    json values = {row.interval};
    for (int i = 0; i < row.tool_count; ++i) {
      values.insert(values.end(), {row.force[i], row.depth[i], row.guard_flags[i]});
    }
    rows.push_back(values);
  }
  seen->row = rows_end;
  AddMember("rows", Text(rows), members);
}

void DashboardState::AddEvents(Seen* seen, std::string* members) const {
  if (events_.empty() || seen->event == events_.back().number) return;
  json list = json::array();
  for (const Happened& happened : events_) {
    if (happened.number <= seen->event) continue;
    list.push_back({{"time", static_cast<double>(happened.event.time_ns) / 1e9},
                    {"severity", happened.event.severity},
                    {"name", happened.event.name},
                    {"text", happened.event.text}});
  }
  seen->event = events_.back().number;
  AddMember("events", Text(list), members);
}

void DashboardState::AddChannels(std::int64_t now_us, Seen* seen, std::string* members) const {
  const auto now = std::chrono::steady_clock::now();
  if (messages() == 0 || now - seen->channels < kChannelsEvery) return;
  seen->channels = now;
  AddMember("channels", ChannelsJson(now_us), members);
  json errors = json::array();
  for (const auto& [number, organ] : organs_) {
    if (!organ.mesh.error().empty()) errors.push_back({number, organ.mesh.error()});
  }
  AddMember("mesh_errors", Text(errors), members);
}

std::string DashboardState::Update(std::int64_t now_us, Seen* seen) {
  std::string members;
  AddReset(seen, &members);
  if (seen->names != names_version_) {
    seen->names = names_version_;
    AddMember("instruments", Text(instruments_), &members);
  }
  AddOrgans(seen, &members);
  AddRows(seen, &members);
  if (seen->tools != tools_version_) {
    seen->tools = tools_version_;
    AddMember("tools", ToolsJson(), &members);
  }
  if (seen->health != health_version_) {
    seen->health = health_version_;
    AddMember("health", HealthJson(), &members);
  }
  if (seen->exercise != exercise_version_) {
    seen->exercise = exercise_version_;
    AddMember("exercise", ExerciseJson(), &members);
  }
  AddEvents(seen, &members);
  AddChannels(now_us, seen, &members);
  return members;
}

std::string DashboardState::ToolsJson() const {
  json value = {{"begin", static_cast<double>(trace_.begin_ns()) / 1e9}};
  json& tools = value["tools"] = json::array();
  if (force_) {
    value["time"] = static_cast<double>(force_->time_ns) / 1e9;
    for (int i = 0; i < force_->tool_count; ++i) {
      const tool_force_t& tool = force_->tools[i];
      const ForceTrace::Peak& peak = trace_.peaks()[i];
      tools.push_back({{"force", Vector(tool.force)},
                       {"depth", tool.depth},
                       {"organ", tool.organ},
                       {"kind", tool.kind},
                       {"guard_flags", tool.guard_flags},
                       {"peak_force", peak.force},
                       {"peak_depth", peak.depth}});
    }
  }
  if (contact_) {
    value["step"] = contact_->step;
    value["step_flags"] = contact_->flags;
    json& poses = value["poses"] = json::array();
    for (const tool_contact_t& tool : contact_->tools) {
      poses.push_back({{"tip", Vector(tool.p_tip)}, {"trocar", Vector(tool.p_trocar)}});
    }
  }
  return Text(value);
}

std::string DashboardState::HealthJson() const {
  if (!stats_) return "null";
  const stats_t& s = *stats_;
  return Text({{"counted_s", static_cast<double>(counted_ns_) / 1e9},
               {"haptic", LoopJson(s.haptic, missed_[0])},
               {"deformation", LoopJson(s.deformation, missed_[1])},
               {"render", LoopJson(s.render, missed_[2])},
               {"skipped_late_wake_up", skipped_[0]},
               {"skipped_long_compute", skipped_[1]},
               {"skipped_stalled", skipped_[2]},
               {"stolen_ms", static_cast<double>(stolen_ns_) / 1e6},
               {"queue_overflows", s.queue_overflows},
               {"log_events", s.log_events},
               {"log_dropped", s.log_dropped},
               {"live_errors", s.live_errors},
               {"latencies", latencies_.ToJson()}});
}

std::string DashboardState::ExerciseJson() const {
  if (!exercise_) return "null";
  const exercise_t& e = *exercise_;
  return Text({{"name", e.name},
               {"step", e.step},
               {"steps", e.step_count},
               {"instruction", e.instruction},
               {"progress", e.progress},
               {"time", e.time},
               {"time_left", e.time_left},
               {"score", e.score},
               {"errors", e.error_count},
               {"restarts", e.restarts},
               {"last_error", e.last_error},
               {"error_time", e.error_time},
               {"ended", e.ended != 0},
               {"passed", e.passed != 0}});
}

std::string DashboardState::ChannelsJson(std::int64_t now_us) const {
  json rows = json::array();
  for (const ChannelRow& row : channels_.Rows(now_us)) {
    rows.push_back({{"channel", row.facts.channel},
                    {"type", row.facts.type},
                    {"messages", row.facts.messages},
                    {"rate_hz", row.flow.rate_hz},
                    {"bytes_per_s", row.flow.bytes_per_s},
                    {"lost", row.facts.lost},
                    {"unreadable", row.facts.unreadable}});
  }
  return Text(rows);
}

std::string DashboardState::MeshJson(int number) const {
  const auto at = organs_.find(number);
  if (at == organs_.end() || !at->second.mesh.whole()) return {};
  const OrganDescription& organ = *at->second.mesh.whole();
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> vertices =
      organ.vertices.cast<float>();
  json value = {{"name", organ.name},
                {"version", at->second.mesh_version},
                {"vertices", Base64Of(vertices)},
                {"triangles", Base64Of(organ.triangles)}};
  if (organ.lattice) {
    const LatticeDescription& lattice = *organ.lattice;
    json axes = json::array();
    for (int d = 0; d < 3; ++d) axes.push_back(Vector(lattice.axes.col(d).data()));
    value["lattice"] = {{"basis", lattice.basis == BasisType::kBSpline ? "bspline" : "bernstein"},
                        {"degree", lattice.degree},
                        {"cells", lattice.cells},
                        {"origin", Vector(lattice.origin_W.data())},
                        {"axes", axes},
                        {"lengths", Vector(lattice.lengths.data())},
                        {"kept", Base64Of(lattice.kept)},
                        {"local_refinement", lattice.local_refinement}};
  }
  return Text(value);
}

}  // namespace hpdm
