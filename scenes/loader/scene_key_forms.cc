#include "scenes/loader/scene_key_forms.h"

#include <algorithm>
#include <functional>
#include <string_view>

#include "scenes/loader/scene_parts.h"
#include "scenes/loader/toml_document.h"

namespace hpdm {
namespace {

// Every table, and every way through the readers that asks for other keys or limits. Its files need
// not exist.
constexpr std::string_view kEveryTable = R"toml(
[scene]
[timing]
[laparoscope]

[[organ]]
name = "a"
mesh = "a.obj"
[organ.pose]
[organ.motion]
displacement = [0, 0, 0]
frequency = 0
[organ.lattice]
[organ.energy]
[organ.material]
[[organ.material.prony]]
share = 0.5
time = 1
[[organ.region]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
young = 1
[[organ.region]]
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
young = 1
[[organ.region]]
sphere = { centre = [0, 0, 0], radius = 1 }
young = 1
[[organ.support]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
fixed = true
[[organ.support]]
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
fixed = true
[[organ.support]]
sphere = { centre = [0, 0, 0], radius = 1 }
fixed = true

[[organ]]
name = "b"
mesh = "b.obj"
unit = "mm"
lattice = { basis = "bernstein" }
free = { drag = 1 }

[[organ]]
name = "c"
mesh = "a.obj"
[[organ.lumen]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
[[organ.lumen]]
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
[[organ.lumen]]
sphere = { centre = [0, 0, 0], radius = 1 }
[[organ.layer]]
box = { min = [0, 0, 0], max = [1, 1, 1] }
stiffness = 1
[[organ.layer]]
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
stiffness = 1
[[organ.layer]]
sphere = { centre = [0, 0, 0], radius = 1 }
stiffness = 1

[[organ]]
name = "d"
mesh = "a.obj"
[[organ]]
name = "e"
mesh = "a.obj"

[[contact]]
a = "a"
b = "b"

[[attachment]]
a = "c"
b = "d"
box = { min = [0, 0, 0], max = [1, 1, 1] }
young = 1
thickness = 0.1
strength = 1
toughness = 1
[[attachment]]
a = "c"
b = "d"
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
young = 1
thickness = 0.1
strength = 1
toughness = 1
[[attachment]]
a = "d"
b = "e"
sphere = { centre = [0, 0, 0], radius = 1 }
young = 1
thickness = 0.1
strength = 1
toughness = 1

[[duct]]
name = "a"
a = "d"
path = [[0, 0, 0], [0, 0, 1]]
radius = 0.01
wall = 0.001
young = 1

[[cut]]
organ = "a"
strip = [[[0, 0, 0], [0, 0, 1]], [[1, 0, 0], [1, 0, 1]]]

[[instrument]]
name = "a"
type = "grasper"
trocar = [0, 0, 0]
mesh = "a.obj"
[instrument.jaws]
meshes = ["a.obj"]
pivot = 0
opening_deg = 1
[instrument.device]
[instrument.hand]
[instrument.trace]
[[instrument.exchange]]
name = "b"
mesh = "a.obj"
[instrument.exchange.jaws]
meshes = ["a.obj"]
pivot = 0
opening_deg = 1

[[load]]
organ = "a"
point = [0, 0, 0]
radius = 1
displacement = [0, 0, 0]
[[load]]
organ = "a"
pressure = 0
box = { min = [0, 0, 0], max = [1, 1, 1] }
[[load]]
organ = "a"
pressure = 0
box_fraction = { min = [0, 0, 0], max = [1, 1, 1] }
[[load]]
organ = "a"
pressure = 0
sphere = { centre = [0, 0, 0], radius = 1 }

[exercise]
[[exercise.step]]
name = "a"
hold = "a"
hold_with = "a"
lift = 1
touch = "a"
touch_with = "a"
at = [0, 0, 0]
within = 1
free = "d"
from = "e"
area = 1
clip = "a"
clips = 1
cut = "a"
[[exercise.error]]
kind = "force"
[[exercise.error]]
kind = "early_cut"
before = "a"
[[exercise.error]]
kind = "near_burn"
path = [[0, 0, 0], [0, 0, 1]]
within = 1

[[file]]
name = "a.obj"
sha256 = "0000000000000000000000000000000000000000000000000000000000000000"
)toml";

/// Returns "organ.lattice" for the reader's path "organ[0].lattice".
std::string WithoutNumbers(std::string_view path) {
  std::string plain;
  bool in_number = false;
  for (const char c : path) {
    if (c == '[') in_number = true;
    if (!in_number) plain += c;
    if (c == ']') in_number = false;
  }
  return plain;
}

class FormCollector : public KeyObserver {
 public:
  void OnTable(std::string_view table) override { ++seen_[WithoutNumbers(table)].tables; }

  void OnKey(std::string_view table, std::string_view key, const KeyForm& form) override {
    std::vector<KeyForm>& forms = seen_[WithoutNumbers(table)].form.keys[std::string(key)];
    const auto same =
        std::ranges::find_if(forms, [&](const KeyForm& other) { return other.type == form.type; });
    if (same == forms.end()) {
      forms.push_back(form);
    } else {
      Widen(form.range, &same->range);
    }
  }

  void OnValues(std::string_view table, std::string_view key,
                const std::vector<double>& values) override {
    for (KeyForm& form : seen_[WithoutNumbers(table)].form.keys[std::string(key)]) {
      form.only = values;
    }
  }

  void OnRequired(std::string_view table, std::string_view key) override {
    ++seen_[WithoutNumbers(table)].requests[std::string(key)];
  }

  void OnExclusive(std::string_view table, std::string_view a, std::string_view b) override {
    seen_[WithoutNumbers(table)].form.exclusive.emplace(a, b);
  }

  std::map<std::string, TableForm, std::less<>> Forms() const {
    std::map<std::string, TableForm, std::less<>> forms;
    for (const auto& [path, seen] : seen_) {
      TableForm& form = forms[path] = seen.form;
      for (const auto& [key, requests] : seen.requests) {
        if (requests == seen.tables) form.required.insert(key);
      }
    }
    return forms;
  }

 private:
  struct Seen {
    TableForm form;
    int tables = 0;
    std::map<std::string, int> requests;  ///< Tables that had to have the key.
  };

  /// If a limit depends on other keys, the form has the widest limit.
  static void Widen(const Interval& other, Interval* range) {
    if (other.min < range->min || (other.min == range->min && !other.above_min)) {
      range->min = other.min;
      range->above_min = other.above_min;
    }
    if (other.max > range->max || (other.max == range->max && !other.below_max)) {
      range->max = other.max;
      range->below_max = other.below_max;
    }
  }

  std::map<std::string, Seen> seen_;
};

}  // namespace

std::map<std::string, TableForm, std::less<>> SceneKeyForms() {
  FormCollector collector;
  ReadScene(ParseToml(std::string(kEveryTable), "every_table.toml"), &collector);
  return collector.Forms();
}

}  // namespace hpdm
