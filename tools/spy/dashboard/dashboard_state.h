#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/analysis/channel_table.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tools/shared/latency_sums.h"
#include "tools/shared/mesh_parts.h"
#include "tools/spy/dashboard/force_trace.h"
#include "tools/spy/dashboard/tick_order.h"

namespace hpdm {

/// The state of a session that the dashboard shows, from the session's messages alone. Messages may
/// have any order and content: the channel table counts a message that is not of its channel's
/// type, which changes nothing else. Memory is bounded. One thread at a time.
class DashboardState {
 public:
  static constexpr std::size_t kMaxEvents = 100;
  /// Bounds for all organs' meshes, and for the message of one organ's shape.
  static constexpr std::size_t kMaxMeshBytes = 256 << 20;
  static constexpr std::size_t kMaxShapeBytes = 1 << 20;

  /// The schemas name the channels' types and outlive the state.
  explicit DashboardState(const MessageSchemas& schemas = MessageSchemas::Hpdm())
      : channels_(schemas) {}

  void Take(const LogEvent& event);
  /// Call at the end of a log: shows values that are still being gathered.
  void Finish();
  /// Call after a seek in a log: restarts everything except the meshes and the instruments' names.
  void Interrupt();
  /// Takes an event or a mesh from before the place of a seek without counting it.
  void Recall(const LogEvent& event);

  /// The state that a viewer has received.
  struct Seen {
    std::uint64_t generation = 0;
    std::uint64_t row = 0;
    std::uint64_t tools = 0;
    std::uint64_t health = 0;
    std::uint64_t event = 0;
    std::uint64_t names = 0;
    std::uint64_t exercise = 0;
    std::chrono::steady_clock::time_point channels{};
    std::array<std::uint64_t, kMaxOrgans> meshes{};
    std::array<std::uint64_t, kMaxOrgans> shapes{};
  };

  /// Returns the changes since `seen`, and updates `seen`. The changes are the members of a JSON
  /// object without its braces; empty if there are none. `now_us`: as LogEvent::time_us, for the
  /// rates.
  std::string Update(std::int64_t now_us, Seen* seen);
  /// Returns an organ's rest mesh and lattice as JSON; empty if unknown.
  std::string MeshJson(int organ) const;

  /// Returns the time stamp of the newest message.
  std::int64_t newest_us() const { return newest_us_; }
  std::uint64_t messages() const { return channels_.messages(); }
  /// True if ticks of two sessions come mixed.
  bool two_sessions() const { return order_.two_sessions(); }

 private:
  struct Organ {
    MeshParts mesh;
    std::uint64_t mesh_version = 0;  // unique over all organs and time; 0 without a mesh
    std::optional<organ_t> shape;
    std::uint64_t shape_version = 0;  // unique over all organs and time
    std::string shape_json;
    std::uint64_t shape_json_version = 0;
  };
  struct Happened {
    std::uint64_t number;
    event_t event;
  };

  void Take(const force_t& force);
  void Take(const contact_t& contact);
  void Take(organ_t&& organ);
  void Take(mesh_t&& part);
  void Take(const stats_t& stats);
  void Take(const event_t& event);
  void Take(const exercise_t& exercise);
  void AddEvent(const event_t& event);
  void Restart();
  void AddReset(Seen* seen, std::string* members) const;
  void AddOrgans(Seen* seen, std::string* members);
  void AddRows(Seen* seen, std::string* members) const;
  void AddEvents(Seen* seen, std::string* members) const;
  void AddChannels(std::int64_t now_us, Seen* seen, std::string* members) const;
  const std::string& ShapeJson(int organ);
  std::string ToolsJson() const;
  std::string HealthJson() const;
  std::string ExerciseJson() const;
  std::string ChannelsJson(std::int64_t now_us) const;

  ChannelTable channels_;
  std::int64_t newest_us_ = 0;
  std::uint64_t generation_ = 1;
  ForceTrace trace_;
  TickOrder order_;
  std::optional<force_t> ahead_;  // a tick that jumped ahead, until another follows it
  std::uint64_t versions_ = 0;    // number of versions of meshes and shapes so far
  std::uint64_t tools_version_ = 0, health_version_ = 0, names_version_ = 0, events_count_ = 0;
  std::uint64_t exercise_version_ = 0;
  std::optional<force_t> force_;
  std::optional<contact_t> contact_;
  std::optional<stats_t> stats_;
  std::optional<exercise_t> exercise_;  // of a scene with one
  LatencySums latencies_;
  std::array<std::int64_t, 3> missed_{};         // haptic, deformation, render
  std::array<std::int64_t, 3> skipped_{};        // late wake-up, long compute, stalled
  std::int64_t stolen_ns_ = 0, counted_ns_ = 0;  // sums over HPDM_STATS, like the two above
  std::vector<std::string> instruments_;
  std::map<int, Organ> organs_;
  std::deque<Happened> events_;
};

}  // namespace hpdm
