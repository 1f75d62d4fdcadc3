#include "tools/report/metrics/report_json.h"

#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>

#include "tools/report/metrics/goals.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// 2026-01-31T12:00:00Z; null when the session has no wall time.
Json StartText(std::int64_t start_us) {
  if (start_us == 0) return nullptr;
  const std::time_t seconds = static_cast<std::time_t>(start_us / 1'000'000);
  std::tm utc{};
  char text[40];
  if (gmtime_r(&seconds, &utc) == nullptr ||
      std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc) == 0) {
    return nullptr;
  }
  return text;
}

void AddSession(const SessionReport& report, Json* json) {
  (*json)["log"] = report.log;
  (*json)["scene"] = report.scene.empty() ? Json(nullptr) : Json(report.scene);
  (*json)["left_handed"] = report.left_handed;
  (*json)["start"] = StartText(report.start_us);
  (*json)["measured"] = report.measured;
  (*json)["duration_s"] = report.duration;
  (*json)["active_s"] = report.active;
  (*json)["paused_s"] = report.paused;
  (*json)["force_limit_N"] = report.force_limit;
  (*json)["depth_limit_m"] = report.depth_limit;
  (*json)["ticks_per_output"] = report.output_interval;
  (*json)["both_moving_s"] = OrNull(report.both_moving);
  (*json)["any_moving_s"] = report.work ? Json(report.work->any_moves) : Json(nullptr);
  (*json)["working_together_s"] = report.work ? Json(report.work->together) : Json(nullptr);
}

void AddContact(const ContactMetrics& contact, Json* json) {
  (*json)["contact_time_s"] = contact.time;
  (*json)["contacts"] = contact.count;
  (*json)["forces_off_s"] = contact.forces_off;
  (*json)["forces_clamped_s"] = contact.clamped;
  (*json)["peak_force_N"] = contact.peak_force;
  (*json)["mean_force_N"] = contact.mean_force;
  (*json)["force_impulse_Ns"] = contact.impulse;
  (*json)["over_limit_s"] = contact.over_limit;
  (*json)["over_limit_count"] = contact.over_limit_count;
  (*json)["deepest_press_m"] = contact.deepest_press;
  (*json)["over_depth_s"] = contact.over_depth;
  (*json)["over_depth_count"] = contact.over_depth_count;
  (*json)["slips"] = contact.slips;
}

void AddHand(const HandReport& hand, Json* json) {
  const MotionMetrics& motion = hand.motion;
  (*json)["name"] = hand.name;
  (*json)["instruments"] = hand.Label();
  (*json)["time_s"] = motion.time;
  (*json)["path_length_m"] = motion.path_length;
  (*json)["angular_path_rad"] = motion.angular_path;
  (*json)["roll_path_rad"] = motion.roll_path;
  (*json)["insertion_path_m"] = motion.insertion_path;
  (*json)["economy_of_motion"] = OrNull(motion.economy);
  (*json)["movements"] = motion.movements;
  (*json)["mean_speed_m_per_s"] = motion.mean_speed;
  (*json)["peak_speed_m_per_s"] = motion.peak_speed;
  (*json)["smoothness_sparc"] = OrNull(motion.smoothness);
  (*json)["idle_s"] = motion.idle;
  (*json)["advances"] = motion.advances;
  (*json)["overshoots"] = motion.overshoots;
  AddContact(hand.contact, json);
  (*json)["mean_force_rate_N_per_s"] = motion.mean_force_rate;
  (*json)["peak_force_rate_N_per_s"] = motion.peak_force_rate;
  (*json)["device_lost_s"] = hand.device_lost;
  (*json)["depth_unknown_s"] = hand.depth_unknown;
}

double Microseconds(Nanoseconds time) { return static_cast<double>(time) / 1000; }

Json LatencyToJson(const LatencyReport& latency) {
  return {{"name", latency.name},
          {"count", latency.count},
          {"p50_us", Microseconds(latency.p50)},
          {"p90_us", Microseconds(latency.p90)},
          {"p99_us", Microseconds(latency.p99)},
          {"p99_9_us", Microseconds(latency.p99_9)},
          {"max_us", Microseconds(latency.max)}};
}

Json HealthToJson(const LogReport& health) {
  return {{"sound", health.Sound()},
          {"closed", health.closed},
          {"bytes", health.bytes},
          {"events", health.events},
          {"damaged_bytes", health.damaged_bytes},
          {"torn_bytes", health.torn_bytes},
          {"unreadable", health.unreadable},
          {"ticks_lost", health.ticks_lost},
          {"outputs_lost", health.outputs_lost},
          {"messages_lost", health.lost},
          {"faults", health.Faults()}};
}

const char* SeverityName(EventSeverity severity) {
  switch (severity) {
    case EventSeverity::kWarning:
      return "warning";
    case EventSeverity::kError:
      return "error";
    default:
      return "info";
  }
}

Json ExerciseToJson(const ExerciseReport& exercise, const SessionReport& report) {
  const std::vector<std::string>& organs = report.organs;
  const ExerciseOptions& options = exercise.options;
  const ExerciseResult& result = exercise.result;
  Json steps = Json::array(), errors = Json::array();
  for (std::size_t s = 0; s < options.steps.size(); ++s) {
    steps.push_back(
        {{"name", options.steps[s].name},
         {"done_s", s < result.step_times.size() ? Json(result.step_times[s]) : Json(nullptr)}});
  }
  for (const ExerciseError& error : result.errors) {
    const ExerciseErrorOptions& rule = options.errors[static_cast<std::size_t>(error.rule)];
    const auto organ = static_cast<std::size_t>(error.organ);
    const bool has_hand = error.hand >= 0 && ToSize(error.hand) < report.hands.size();
    errors.push_back(
        {{"name", rule.name},
         {"time_s", error.time},
         {"points", rule.points},
         {"hand", error.hand < 0 ? Json(nullptr) : Json(error.hand)},
         {"instrument",
          has_hand ? Json(report.hands[ToSize(error.hand)].InstrumentName(error.instrument_index))
                   : Json(nullptr)},
         {"organ", error.organ < 0 || organ >= organs.size() ? Json(nullptr) : Json(organs[organ])},
         {"duct", error.duct < 0 ? Json(nullptr) : Json(options.ducts.at(ToSize(error.duct)).name)},
         {"place_m", {error.place_W.x(), error.place_W.y(), error.place_W.z()}},
         {"force_N", error.force},
         {"clip_faults", FaultText(error.clip, "", false)}});
  }
  Json bleedings = Json::array();
  for (const ExerciseBleeding& bleeding : result.bleedings) {
    bleedings.push_back({{"begin_s", bleeding.begin},
                         {"lasted_s", bleeding.end - bleeding.begin},
                         {"stopped", bleeding.stopped}});
  }
  Json restarts = Json::array();
  for (const ExerciseRestart& restart : result.restarts) {
    restarts.push_back({{"step", options.steps[ToSize(restart.step)].name},
                        {"begin_s", restart.time},
                        {"discarded_s", restart.discarded},
                        {"discarded_errors", restart.errors}});
  }
  return {{"name", options.name},
          {"score", result.score},
          {"passed", result.passed},
          {"ended", result.ended},
          {"time_s", result.time},
          {"stood_s", result.stood},
          {"error_count", result.errors.size()},
          {"restart_count", result.restarts.size()},
          {"steps", steps},
          {"errors", errors},
          {"bleedings", bleedings},
          {"restarts", restarts}};
}

}  // namespace

Json ToJson(const SessionReport& report) {
  Json json = Json::object();
  AddSession(report, &json);
  json["hands"] = Json::array();
  for (const HandReport& hand : report.hands) {
    Json entry = Json::object();
    AddHand(hand, &entry);
    entry["organs"] = Json::array();
    for (std::size_t o = 0; o < hand.by_organ.size(); ++o) {
      Json organ = {{"organ", report.organs[o]}};
      AddContact(hand.by_organ[o], &organ);
      entry["organs"].push_back(std::move(organ));
    }
    json["hands"].push_back(std::move(entry));
  }
  json["attachments"] = Json::array();
  for (const AttachmentReport& attachment : report.attachments) {
    json["attachments"].push_back({{"name", attachment.name},
                                   {"peak_load_N", attachment.peak_load},
                                   {"largest_damage", attachment.largest_damage},
                                   {"freed_area_m2", attachment.freed_area},
                                   {"burnt_area_m2", attachment.burnt_area},
                                   {"cut_area_m2", attachment.cut_area},
                                   {"dissipated_J", attachment.dissipated}});
  }
  if (report.exercise) json["exercise"] = ExerciseToJson(*report.exercise, report);
  json["goals"] = Json::object();
  for (const GoalsDomain& domain : RateGoals(report)) {
    Json parts = Json::object();
    for (const GoalsPart& part : domain.parts) parts[part.key] = part.value;
    json["goals"][domain.key] = {
        {"rating", OrNull(domain.rating)},
        {"figures", parts},
        {"why_not", domain.why_not.empty() ? Json(nullptr) : Json(domain.why_not)}};
  }
  json["latencies"] = Json::array();
  for (const LatencyReport& latency : report.latencies) {
    if (latency.count > 0) json["latencies"].push_back(LatencyToJson(latency));
  }
  json["ticks"] = report.ticks;
  json["skipped"] = {{"total", report.skipped.Total()},
                     {"late_wake_up", report.skipped.late_wake_up},
                     {"long_compute", report.skipped.long_compute},
                     {"stalled", report.skipped.stalled}};
  json["stolen_s"] = report.stolen;
  json["steps_shed"] = report.steps_shed;
  json["log_health"] = HealthToJson(report.health);
  json["events"] = Json::array();
  for (const SessionEvent& event : report.events) {
    json["events"].push_back({{"time_s", event.time},
                              {"severity", SeverityName(event.severity)},
                              {"name", event.name},
                              {"text", event.text}});
  }
  return json;
}

}  // namespace hpdm
