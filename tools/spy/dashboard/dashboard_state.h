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

/// What the dashboard shows of a session, from its messages alone, in any order and of any content:
/// what is not one sound message of its channel's type is counted by the channel table and changes
/// nothing. Memory is bounded whatever comes. One thread at a time.
class DashboardState {
 public:
  static constexpr std::size_t kMaxEvents = 100;
  /// Of all organs' meshes; and of one organ's shape, as a message.
  static constexpr std::size_t kMaxMeshBytes = 256 << 20;
  static constexpr std::size_t kMaxShapeBytes = 1 << 20;

  /// The schemas name the channels' types and outlive the state.
  explicit DashboardState(const MessageSchemas& schemas = MessageSchemas::Hpdm())
      : channels_(schemas) {}

  void Take(const LogEvent& event);
  /// Nothing more comes for now (the end of a log): what is still being gathered is shown.
  void Finish();
  /// The messages to come do not follow those before (a seek in a log): all but the meshes and the
  /// instruments' names starts anew.
  void Interrupt();
  /// Takes what was before the place of a seek and counts it nowhere: an event for the list of
  /// events and the instruments' names, a mesh.
  void Recall(const LogEvent& event);

  /// What one viewer has been sent.
  struct Seen {
    std::uint64_t generation = 0;
    std::uint64_t row = 0;
    std::uint64_t tools = 0;
    std::uint64_t health = 0;
    std::uint64_t event = 0;
    std::uint64_t names = 0;
    std::chrono::steady_clock::time_point channels{};
    std::array<std::uint64_t, kMaxOrgans> meshes{};
    std::array<std::uint64_t, kMaxOrgans> shapes{};
  };

  /// What is new since `seen`, which is brought up to date, as the members of a JSON object without
  /// its braces; empty when nothing is. `now_us`: as LogEvent::time_us counts, for the rates.
  std::string Update(std::int64_t now_us, Seen* seen);

  /// An organ's rest mesh and lattice as JSON; empty before it is known.
  std::string MeshJson(int organ) const;

  /// Time stamp of the newest message.
  std::int64_t newest_us() const { return newest_us_; }
  std::uint64_t messages() const { return channels_.messages(); }
  /// Ticks of two sessions' clocks come mixed.
  bool two_sessions() const { return order_.two_sessions(); }

 private:
  struct Organ {
    MeshParts mesh;
    std::uint64_t mesh_version = 0;  // unlike any before of any organ; 0 without a mesh
    std::optional<organ_t> shape;
    std::uint64_t shape_version = 0;  // likewise
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
  void AddEvent(const event_t& event);
  void BeginAnew();
  const std::string& ShapeJson(int organ);
  std::string ToolsJson() const;
  std::string HealthJson() const;
  std::string ChannelsJson(std::int64_t now_us) const;

  ChannelTable channels_;
  std::int64_t newest_us_ = 0;
  std::uint64_t generation_ = 1;
  ForceTrace trace_;
  TickOrder order_;
  std::optional<force_t> ahead_;  // a tick that jumped ahead, until one follows it
  std::uint64_t versions_ = 0;    // of meshes and shapes, so far
  std::uint64_t tools_version_ = 0, health_version_ = 0, names_version_ = 0, events_count_ = 0;
  std::optional<force_t> force_;
  std::optional<contact_t> contact_;
  std::optional<stats_t> stats_;
  LatencySums latencies_;
  std::array<std::int64_t, 3> missed_{};         // haptic, deformation, render
  std::array<std::int64_t, 3> skipped_{};        // late wake-up, long compute, stalled
  std::int64_t stolen_ns_ = 0, counted_ns_ = 0;  // sums over HPDM_STATS, as all before
  std::vector<std::string> instruments_;
  std::map<int, Organ> organs_;
  std::deque<Happened> events_;
};

}  // namespace hpdm
