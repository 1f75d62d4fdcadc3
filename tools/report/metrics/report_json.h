#pragma once

#include <nlohmann/json.hpp>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Returns the output of `hpdm report --json`. Keys contain their units and are stable. Missing
/// values are null. Text may not be UTF-8: print with JsonText.
///
///     log, scene, left_handed, start, measured, duration_s, active_s, paused_s, force_limit_N,
///     depth_limit_m, ticks_per_output, both_moving_s, any_moving_s, working_together_s, hands: [{name, instruments, time_s, path_length_m, ..., organs: [{organ,
///     contact_time_s, ...}]}], latencies: [{name, count, p50_us, p90_us, p99_us, p99_9_us,
///     max_us}], exercise: {name, score, passed, ended, time_s, stood_s, error_count, restart_count, steps: [{name, done_s}], errors: [{name,
///     time_s, points, hand, organ, place_m, force_N, clip_faults}], bleedings: [{begin_s, lasted_s, stopped}], restarts: [{step, begin_s, discarded_s, discarded_errors}]} (only of a scene with one), goals: {DOMAIN: {rating, figures: {...}, why_not}}, ticks, skipped: {total, late_wake_up, long_compute, stalled}, stolen_s,
///     steps_shed, log_health: {sound, bytes, ..., faults: [text]}, events: [{time_s, severity,
///     name, text}]
nlohmann::ordered_json ToJson(const SessionReport& report);

}  // namespace hpdm
