#include "tools/session/control_script.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

// A change of one hand's controls.
struct Change {
  Nanoseconds time_ns;
  std::size_t instrument;
  std::optional<int> instrument_index;
  std::optional<bool> pedal;
  std::string name;
  std::optional<int> restart_step;
};

[[noreturn]] void Fail(const char* option, const std::string& argument, const std::string& why) {
  throw InputError(std::string(option) + " " + argument + ": " + why);
}

std::optional<double> SecondsIn(std::string_view text) {
  double seconds = -1;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, seconds);
  if (error != std::errc() || stop != end || !(seconds >= 0 && seconds <= 1e6)) return {};
  return seconds;
}

Change ParseExchange(const std::string& argument,
                     const std::vector<InstrumentOptions>& instruments) {
  const std::size_t at = argument.rfind('@');
  const auto seconds =
      at == std::string::npos ? std::nullopt : SecondsIn(std::string_view(argument).substr(at + 1));
  if (!seconds) {
    Fail("--exchange", argument,
         "is not an exchange; give NAME=OTHER@SECONDS, such as probe=hook@3");
  }
  const std::string names = argument.substr(0, at);
  std::string known;
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    for (int instrument_index = 0; instrument_index < instruments[i].HeldCount();
         ++instrument_index) {
      const std::string held =
          instruments[i].name + "=" + instruments[i].Held(instrument_index).name;
      if (held == names) {
        return {std::llround(*seconds * 1e9),
                i,
                instrument_index,
                {},
                "exchange of " + instruments[i].name + " to " +
                    instruments[i].Held(instrument_index).name + " at " + argument.substr(at + 1) +
                    " s",
                {}};
      }
      AppendToList(held, &known);
    }
  }
  Fail("--exchange", argument,
       "unknown exchange; the scene has " + (known.empty() ? "none" : known));
}

// Adds the press and the release.
void ParsePedal(const std::string& argument, const std::vector<InstrumentOptions>& instruments,
                std::vector<Change>* changes) {
  const std::size_t at = argument.rfind('@'), to = argument.rfind('-');
  std::optional<double> from, until;
  if (at != std::string::npos && to != std::string::npos && to > at) {
    from = SecondsIn(std::string_view(argument).substr(at + 1, to - at - 1));
    until = SecondsIn(std::string_view(argument).substr(to + 1));
  }
  if (!from || !until || *until <= *from) {
    Fail("--pedal", argument, "is not a press of a pedal; give NAME@FROM-TO, such as hook@3-5.5");
  }
  const std::string name = argument.substr(0, at);
  std::string known;
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    if (instruments[i].name != name) {
      AppendToList(instruments[i].name, &known);
      continue;
    }
    changes->push_back({std::llround(*from * 1e9),
                        i,
                        {},
                        true,
                        "pedal of " + name + " at " + argument.substr(at + 1) + " s",
                        {}});
    changes->push_back(
        {std::llround(*until * 1e9),
         i,
         {},
         false,
         "release of the pedal of " + name + " after " + argument.substr(at + 1) + " s",
         {}});
    return;
  }
  Fail("--pedal", argument, "unknown instrument; the scene has " + known);
}

Change ParseRestart(const std::string& argument, const Scene& scene) {
  if (!scene.exercise) {
    Fail("--restart", argument, "the scene has no exercise; leave it out");
  }
  const auto steps = static_cast<int>(scene.exercise->steps.size());
  const std::size_t at = argument.rfind('@');
  int step = 0;
  std::optional<double> seconds;
  if (at != std::string::npos) {
    const auto [stop, error] = std::from_chars(argument.data(), argument.data() + at, step);
    const bool whole = error == std::errc() && stop == argument.data() + at;
    if (whole) seconds = SecondsIn(std::string_view(argument).substr(at + 1));
  }
  if (!seconds) Fail("--restart", argument, "is not a restart; give STEP@SECONDS, such as 2@30");
  if (step < 1 || step > steps) {
    Fail("--restart", argument,
         "the exercise has no such step; give 1 to " + std::to_string(steps));
  }
  return {std::llround(*seconds * 1e9),
          0,
          {},
          {},
          "restart at step " + std::to_string(step) + " at " + argument.substr(at + 1) + " s",
          step - 1};
}

}  // namespace

void ControlScript::Advance(Nanoseconds now_ns, TripleBuffer<SessionControl>* edge) {
  const std::size_t before = next_;
  for (; next_ < controls_.size() && controls_[next_].time_ns <= now_ns; ++next_) {
    const std::optional<int>& step = controls_[next_].restart_step;
    if (step) restart_ = {restart_.count + 1, *step};
  }
  if (next_ != before) Publish(edge);
}

void ControlScript::SetPaused(bool paused, TripleBuffer<SessionControl>* edge) {
  paused_ = paused;
  Publish(edge);
}

void ControlScript::Restart(int step, TripleBuffer<SessionControl>* edge) {
  restart_ = {restart_.count + 1, step};
  Publish(edge);
}

void ControlScript::Publish(TripleBuffer<SessionControl>* edge) const {
  SessionControl& control = edge->Back();
  control = next_ > 0 ? controls_[next_ - 1].control : SessionControl{};
  control.paused = control.paused || paused_;
  control.restart = restart_;
  edge->Publish();
}

std::vector<std::string> ControlScript::Left() const {
  std::vector<std::string> names;
  for (std::size_t i = next_; i < controls_.size(); ++i) names.push_back(controls_[i].name);
  return names;
}

ControlScript ParseControls(const ControlArguments& arguments, const Scene& scene) {
  std::vector<Change> changes;
  for (const std::string& argument : arguments.exchanges) {
    changes.push_back(ParseExchange(argument, scene.instruments));
  }
  for (const std::string& argument : arguments.pedals) {
    ParsePedal(argument, scene.instruments, &changes);
  }
  for (const std::string& argument : arguments.restarts) {
    changes.push_back(ParseRestart(argument, scene));
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const Change& a, const Change& b) { return a.time_ns < b.time_ns; });
  std::vector<TimedControl> controls;
  SessionControl control;
  for (const Change& change : changes) {
    if (change.instrument_index) {
      control.instrument_index[change.instrument] = *change.instrument_index;
    }
    if (change.pedal) control.pedal[change.instrument] = *change.pedal;
    controls.push_back({change.time_ns, control, change.name, change.restart_step});
  }
  return ControlScript(std::move(controls));
}

}  // namespace hpdm
