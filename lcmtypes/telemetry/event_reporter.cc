#include "lcmtypes/telemetry/event_reporter.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "lcmtypes/telemetry/exercise_events.h"

namespace hpdm {
namespace {

// An organ near the limit of its tissue gives one event, not one a step.
constexpr Nanoseconds kSoundAgain = kNanosecondsPerSecond / 4;
// Share of a bed's area, below 1 by the roundings of its sum.
constexpr double kTornThrough = 1 - 1e-9;

// Share of its strength below which a layer that was beyond it may be reported again.
constexpr double kUnloaded = 0.9;

constexpr char kAwaited[] = ": waiting for a driver on HPDM_DEVICE";
constexpr char kConnected[] = ": device connected: force fading in";
constexpr char kLost[] = ": device lost: pose held, force fading out";
constexpr char kBack[] = ": device back: force fading in";

}  // namespace

EventReporter::EventReporter(const SessionInfo& info, Sink sink, Tell tell)
    : sink_(std::move(sink)),
      tell_(std::move(tell)),
      instruments_(info.instruments),
      held_(info.held),
      attachments_(info.attachments),
      layers_(info.layers),
      lumens_(info.lumens),
      ducts_(info.ducts),
      left_handed_(info.left_handed) {
  for (const OrganDescription& organ : info.organs) organs_.push_back(organ.name);
}

void EventReporter::ReportStart(const Histogram& baseline) {
  sink_(EventSeverity::kInfo, std::string(kSessionStart), SessionStartText(instruments_));
  if (left_handed_ && instruments_.size() > 1) {
    sink_(EventSeverity::kInfo, std::string(kLeftHanded),
          instruments_[0] + " and " + instruments_[1] + " have exchanged their ports");
  }
  if (baseline.count() == 0) return;
  char text[120];
  std::snprintf(text, sizeof text, "an empty loop woke late by %.1f us (p99), %.1f us at most",
                static_cast<double>(baseline.Percentile(0.99)) / 1000,
                static_cast<double>(baseline.max()) / 1000);
  sink_(EventSeverity::kInfo, "realtime.baseline", text);
}

void EventReporter::ReportEnd() {
  sink_(EventSeverity::kInfo, "session.end", "the session was closed");
}

void EventReporter::Add(const HapticSample& sample) {
  AddDevices(sample);
  AddControl(sample);
  AddSlips(sample);
}

void EventReporter::AddDevices(const HapticSample& sample) {
  for (std::size_t i = 0; i < instruments_.size() && static_cast<int>(i) < sample.tool_count; ++i) {
    const bool lost = !sample.tools[i].device_valid;
    const bool changed = lost != device_lost_[i];
    device_lost_[i] = lost;
    TellOfDevice(i, sample.time_ns);
    const bool first = !device_seen_[i];
    device_seen_[i] |= !lost;
    if (!changed || (lost && first)) continue;
    if (lost) {
      sink_(EventSeverity::kWarning, "device.lost", instruments_[i] + kLost);
    } else if (first) {
      sink_(EventSeverity::kInfo, "device.connected", instruments_[i] + kConnected);
    } else {
      sink_(EventSeverity::kInfo, "device.back", instruments_[i] + kBack);
    }
  }
}

// Tells of a change when the last line is a second old, so that a driver that stutters does not
// flood the terminal.
void EventReporter::TellOfDevice(std::size_t instrument, Nanoseconds now) {
  ToldDevice& told = told_devices_[instrument];
  const bool lost = device_lost_[instrument];
  if (lost != told.lost && now - told.at >= kNanosecondsPerSecond) {
    const bool seen = device_seen_[instrument];
    const char* text = lost ? (seen ? kLost : kAwaited) : told.awaited ? kConnected : kBack;
    if (tell_) tell_(instruments_[instrument] + text);
    told.awaited = lost && !seen;
    told.lost = lost;
    told.at = now;
  }
}

void EventReporter::AddControl(const HapticSample& sample) {
  if (sample.paused != control_.paused) {
    control_.paused = sample.paused;
    if (sample.paused) {
      sink_(EventSeverity::kInfo, "session.paused",
            "session paused: hands held, forces fading out");
    } else {
      sink_(EventSeverity::kInfo, "session.resumed", "session resumed, forces fading in");
    }
  }
  for (std::size_t i = 0; i < held_.size() && static_cast<int>(i) < sample.tool_count; ++i) {
    const int instrument_index = sample.tools[i].instrument_index;
    if (instrument_index == control_.instrument_index[i]) continue;
    control_.instrument_index[i] = instrument_index;
    const auto at = static_cast<std::size_t>(instrument_index);
    sink_(EventSeverity::kInfo, "instrument.exchanged",
          instruments_[i] + ": the hand holds " +
              (at < held_[i].size() ? held_[i][at] : std::to_string(instrument_index)) + " now");
  }
}

void EventReporter::AddSlips(const HapticSample& sample) {
  for (std::size_t i = 0; i < instruments_.size() && static_cast<int>(i) < sample.tool_count; ++i) {
    if (!slips_[i].Add(ToSeconds(sample.time_ns), sample.tools[i].slip)) continue;
    sink_(EventSeverity::kInfo, "grasp.slipped", instruments_[i] + ": tissue slips in the jaws");
  }
}

void EventReporter::Add(const StepSample& sample) {
  AddOrgans(sample);
  AddAttachments(sample);
  AddLayers(sample);
  AddLumens(sample);
  AddDucts(sample);
  AddShedding(sample.step.shed_level);
}

void EventReporter::AddOrgans(const StepSample& sample) {
  const auto count = std::min(organs_.size(), static_cast<std::size_t>(sample.organ_count));
  for (std::size_t o = 0; o < count; ++o) {
    const bool recovering = sample.organs[o].recovering;
    if (sample.organs[o].inverted || recovering) {
      organ_unsound_last_[o] = sample.step.time_ns;
      if (organ_unsound_[o]) continue;
      organ_unsound_[o] = true;
      sink_(EventSeverity::kWarning, "organ.inverted",
            organs_[o] + (recovering ? ": its tools ask for more than its tissue can do; it "
                                       "follows them as far as it stays sound"
                                     : ": tissue is turned inside out; picture and forces there "
                                       "are not valid"));
    } else if (organ_unsound_[o] && sample.step.time_ns - organ_unsound_last_[o] >= kSoundAgain) {
      organ_unsound_[o] = false;
      sink_(EventSeverity::kInfo, "organ.recovered",
            organs_[o] + ": its tissue is sound again and follows its tools");
    }
  }
}

void EventReporter::AddAttachments(const StepSample& sample) {
  const auto count = std::min(attachments_.size(), ToSize(sample.attachment_count));
  for (std::size_t a = 0; a < count; ++a) {
    const AttachmentOutcome& now = sample.attachments[a];
    const AttachmentOutcome last = std::exchange(outcomes_[a], now);
    const double whole = attachments_[a].area * kTornThrough;
    const std::string layer = "the layer between " + attachments_[a].name;
    if (last.largest_damage == 0 && now.largest_damage > 0) {
      sink_(EventSeverity::kInfo, "attachment.damaged", layer + " is damaged");
    }
    if (last.freed_area == 0 && now.freed_area > 0) {
      sink_(EventSeverity::kInfo, "attachment.tears", layer + " tears");
    }
    if (last.freed_area < whole && now.freed_area >= whole) {
      sink_(EventSeverity::kInfo, "attachment.torn", layer + " is torn through");
    }
  }
}

void EventReporter::AddLumens(const StepSample& sample) {
  const auto count = std::min(lumens_.size(), ToSize(sample.lumen_count));
  for (std::size_t l = 0; l < count; ++l) {
    const bool was = std::exchange(perforated_[l], sample.lumens[l].perforated);
    if (!perforated_[l] || was) continue;
    sink_(EventSeverity::kWarning, kPerforated.data(), PerforatedText(lumens_[l]));
  }
}

void EventReporter::AddLayers(const StepSample& sample) {
  const auto count = std::min(layers_.size(), ToSize(sample.layer_count));
  for (std::size_t l = 0; l < count; ++l) {
    const double tension = sample.layer_tensions[l], strength = layers_[l].strength;
    if (strength == 0) continue;
    if (tension < kUnloaded * strength) layer_overloaded_[l] = false;
    if (tension <= strength || layer_overloaded_[l]) continue;
    layer_overloaded_[l] = true;
    char text[80];
    std::snprintf(text, sizeof text, " bears %.3g N/m, beyond its strength of %.3g N/m", tension,
                  strength);
    sink_(EventSeverity::kWarning, "layer.overloaded", layers_[l].name + text);
  }
}

void EventReporter::AddDucts(const StepSample& sample) {
  const auto count = std::min(ducts_.size(), ToSize(sample.duct_count));
  for (std::size_t d = 0; d < count; ++d) {
    const DuctOutcome& now = sample.ducts[d];
    const DuctOutcome last = std::exchange(duct_outcomes_[d], now);
    for (int clip = last.clips + 1; clip <= now.clips; ++clip) {
      sink_(EventSeverity::kInfo, "duct.clipped",
            "clip " + std::to_string(clip) + " is on the " + ducts_[d]);
    }
    for (int cut = last.cuts + 1; cut <= now.cuts; ++cut) {
      sink_(EventSeverity::kInfo, "duct.cut",
            "the " + ducts_[d] + " is cut, with " + std::to_string(now.clips) + " clips on it");
    }
  }
}

void EventReporter::AddShedding(int level) {
  if (level == shed_level_) return;
  if (level > shed_level_) {
    sink_(EventSeverity::kWarning, "steps.shed",
          "deformation steps take longer than their budget: reduced quality (level " +
              std::to_string(level) + ")");
  } else if (level > 0) {
    sink_(
        EventSeverity::kInfo, "steps.raised",
        "deformation steps have time again: better quality (level " + std::to_string(level) + ")");
  } else {
    sink_(EventSeverity::kInfo, "steps.restored",
          "deformation steps have time again: full quality");
  }
  shed_level_ = level;
}

void EventReporter::Add(const ExerciseEvaluator& exercise) {
  const ExerciseResult& result = exercise.result();
  AddRestarts(exercise);
  for (; exercise_errors_ < result.errors.size(); ++exercise_errors_) {
    const ExerciseError& error = result.errors[exercise_errors_];
    const std::string faults = FaultText(error.clip, "", false);
    sink_(EventSeverity::kWarning, "exercise.error",
          exercise.options().errors[static_cast<std::size_t>(error.rule)].name +
              (faults.empty() ? "" : ": " + faults));
  }
  for (; exercise_steps_ < result.step_times.size(); ++exercise_steps_) {
    sink_(EventSeverity::kInfo, "exercise.step",
          "done: " + exercise.options().steps[exercise_steps_].name);
  }
  for (; bleedings_over_ < exercise.BleedingsOver(); ++bleedings_over_) {
    sink_(EventSeverity::kInfo, "exercise.bleeding_stopped", "a clip stops the bleeding");
  }
  if (!result.ended || exercise_ended_) return;
  exercise_ended_ = true;
  char text[160];
  std::snprintf(text, sizeof text, "%s after %.1f s with %zu errors: score %.1f of 100",
                result.passed ? "all steps done" : "time over", result.time, result.errors.size(),
                result.score);
  sink_(EventSeverity::kInfo, "exercise.end", text);
}

// What was reported of the discarded steps does not count any more.
void EventReporter::AddRestarts(const ExerciseEvaluator& exercise) {
  const ExerciseResult& result = exercise.result();
  for (; exercise_restarts_ < result.restarts.size(); ++exercise_restarts_) {
    const ExerciseRestart& restart = result.restarts[exercise_restarts_];
    exercise_errors_ -= ToSize(restart.errors);
    exercise_steps_ = ToSize(restart.step);
    bleedings_over_ = exercise.BleedingsOver();
    char text[160];
    std::snprintf(text, sizeof text, "\"%.60s\" begins again: %.1f s and %d errors do not count",
                  exercise.options().steps[ToSize(restart.step)].name.c_str(), restart.discarded,
                  restart.errors);
    sink_(EventSeverity::kInfo, "exercise.restarted", text);
  }
}

void EventReporter::Add(const LoopEvent& event) {
  sink_(event.severity, event.name.data(), event.text.data());
  if (event.severity > EventSeverity::kInfo && tell_) tell_(event.text.data());
}

void EventReporter::AddLosses(std::uint64_t overflows, std::int64_t steps_lost) {
  if (overflows > overflows_) {
    sink_(EventSeverity::kWarning, "telemetry.overflow",
          std::to_string(overflows - overflows_) +
              " ticks found the telemetry queue full and are not in the log");
    overflows_ = overflows;
  }
  if (steps_lost > 0) {
    sink_(EventSeverity::kWarning, "telemetry.steps_lost",
          std::to_string(steps_lost) +
              " deformation steps found the telemetry queue full and are not in the log");
  }
}

void EventReporter::AddFailures(const LogState& log, const std::string& timeline,
                                std::uint64_t live_errors) {
  if (log.failure != LogFailure::kNone) {
    AddOnce(&log_failure_reported_, EventSeverity::kError, "log.failed", log.Explain());
  } else if (log.moved) {
    AddOnce(&log_move_reported_, EventSeverity::kWarning, "log.moved",
            "the session folder was moved or renamed: the session continues in its new place");
  }
  if (!timeline.empty()) {
    AddOnce(&timeline_failure_reported_, EventSeverity::kWarning, "timeline.failed", timeline);
  }
  if (live_errors > 0) {
    AddOnce(&live_failure_reported_, EventSeverity::kWarning, "live.failed",
            "the network refused messages of --live; the log has them all and summary.json counts "
            "them; check the interface and its multicast route");
  }
}

void EventReporter::AddOnce(bool* reported, EventSeverity severity, const char* name,
                            const std::string& text) {
  if (*reported) return;
  *reported = true;
  sink_(severity, name, text);
  if (tell_) tell_(text);
}

}  // namespace hpdm
