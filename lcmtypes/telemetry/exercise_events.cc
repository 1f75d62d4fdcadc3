#include "lcmtypes/telemetry/exercise_events.h"

#include <algorithm>

#include "lcmtypes/telemetry/session_info.h"

namespace hpdm {
namespace {

constexpr std::string_view kNumber = " number ";
constexpr std::string_view kLeaks = " is perforated and leaks";

}  // namespace

std::string LumenName(std::string_view organ, int number) {
  std::string name = "the lumen of " + std::string(organ);
  if (number >= 0) name += std::string(kNumber) + std::to_string(number);
  return name;
}

std::string PerforatedText(std::string_view lumen) {
  return std::string(lumen) + std::string(kLeaks);
}

int PerforatedOrgan(std::string_view text, const std::vector<std::string>& organs) {
  for (std::size_t o = 0; o < organs.size(); ++o) {
    const std::string lumen = LumenName(organs[o]);
    if (!text.starts_with(lumen)) continue;
    std::string_view rest = text.substr(lumen.size());
    if (rest.starts_with(kNumber)) {
      rest.remove_prefix(kNumber.size());
      rest.remove_prefix(std::min(rest.find_first_not_of("0123456789"), rest.size()));
    }
    if (rest == kLeaks) return static_cast<int>(o);
  }
  return -1;
}

void AddExerciseEvent(Nanoseconds time_ns, std::string_view name, std::string_view text,
                      ExerciseEvaluator* exercise) {
  if (name == kBleeding) exercise->AddBleeding(time_ns);
  if (name != kPerforated) return;
  const int organ = PerforatedOrgan(text, exercise->options().organs);
  if (organ >= 0) exercise->AddPerforation(time_ns, organ);
}

}  // namespace hpdm
