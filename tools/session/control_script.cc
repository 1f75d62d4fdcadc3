#include "tools/session/control_script.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/text_list.h"

namespace hpdm {
namespace {

struct Exchange {
  Nanoseconds time_ns;
  std::size_t instrument;
  int instrument_index;
  std::string name;
};

[[noreturn]] void Fail(const std::string& argument, const std::string& why) {
  throw InputError("--exchange " + argument + ": " + why);
}

Exchange Parse(const std::string& argument, const std::vector<InstrumentOptions>& instruments) {
  const std::size_t at = argument.rfind('@');
  double seconds = -1;
  if (at != std::string::npos) {
    const char* end = argument.data() + argument.size();
    const auto [stop, error] = std::from_chars(argument.data() + at + 1, end, seconds);
    if (error != std::errc() || stop != end) seconds = -1;
  }
  if (!(seconds >= 0 && seconds <= 1e6)) {
    Fail(argument, "is not an exchange; give NAME=OTHER@SECONDS, such as probe=hook@3");
  }
  const std::string names = argument.substr(0, at);
  std::string known;
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    for (int instrument_index = 0; instrument_index < instruments[i].HeldCount();
         ++instrument_index) {
      const std::string held =
          instruments[i].name + "=" + instruments[i].Held(instrument_index).name;
      if (held == names) {
        return {std::llround(seconds * 1e9), i, instrument_index,
                "exchange of " + instruments[i].name + " to " +
                    instruments[i].Held(instrument_index).name + " at " + argument.substr(at + 1) +
                    " s"};
      }
      AppendToList(held, &known);
    }
  }
  Fail(argument, "unknown exchange; the scene has " + (known.empty() ? "none" : known));
}

}  // namespace

void ControlScript::Advance(Nanoseconds now_ns, TripleBuffer<SessionControl>* edge) {
  const std::size_t before = next_;
  while (next_ < controls_.size() && controls_[next_].time_ns <= now_ns) ++next_;
  if (next_ == before) return;
  edge->Back() = controls_[next_ - 1].control;
  edge->Publish();
}

std::vector<std::string> ControlScript::Left() const {
  std::vector<std::string> names;
  for (std::size_t i = next_; i < controls_.size(); ++i) names.push_back(controls_[i].name);
  return names;
}

ControlScript ParseExchanges(const std::vector<std::string>& arguments,
                             const std::vector<InstrumentOptions>& instruments) {
  std::vector<Exchange> exchanges;
  for (const std::string& argument : arguments) exchanges.push_back(Parse(argument, instruments));
  std::stable_sort(exchanges.begin(), exchanges.end(),
                   [](const Exchange& a, const Exchange& b) { return a.time_ns < b.time_ns; });
  std::vector<TimedControl> controls;
  SessionControl control;
  for (const Exchange& exchange : exchanges) {
    control.instrument_index[exchange.instrument] = exchange.instrument_index;
    controls.push_back({exchange.time_ns, control, exchange.name});
  }
  return ControlScript(std::move(controls));
}

}  // namespace hpdm
