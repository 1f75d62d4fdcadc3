#include "scenes/loader/not_yet.h"

#include <string>
#include <string_view>

namespace hpdm {
namespace {

// A number that is not zero, or an array that holds one, of a key.
struct Rule {
  std::string_view key;  // without the [index] of arrays
  std::string_view remedy;
};

// Features that scene.h reads and this version does not have. To add a feature, delete its line.
constexpr Rule kRules[] = {
    // The tissue has it, but its force comes with the step's patch, 34 to 67 ms late
    // (tests/haptics/contact/grasp_energy_test.cc).
    {"organ.material.relaxation_time",
     "viscous tissue would drive the hand that grasps it: remove the key or set it to 0"},
    {"scene.gravity", "remove the key or give [0, 0, 0]"},
};

bool IsNonZero(const TomlValue& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value.value)) return *integer != 0;
  if (const auto* number = std::get_if<double>(&value.value)) return *number != 0;
  if (const auto* elements = std::get_if<TomlArray>(&value.value)) {
    for (const TomlValue& element : *elements) {
      if (IsNonZero(element)) return true;
    }
  }
  return false;
}

class Walk {
 public:
  explicit Walk(const TomlDocument& document) : document_(document) {}

  /// `key` is the path as the rules write it, `shown` the one of the messages.
  void Visit(const TomlValue& value, const std::string& key, const std::string& shown) const {
    for (const Rule& rule : kRules) {
      if (rule.key == key && IsNonZero(value)) Refuse(rule, value, shown);
    }
    if (const auto* entries = std::get_if<TomlTable>(&value.value)) {
      const std::string dot = key.empty() ? "" : ".";
      for (const TomlEntry& entry : *entries) {
        Visit(entry.value, key + dot + entry.key, shown + dot + entry.key);
      }
    } else if (const auto* elements = std::get_if<TomlArray>(&value.value)) {
      for (std::size_t i = 0; i < elements->size(); ++i) {
        const TomlValue& element = (*elements)[i];
        if (!std::holds_alternative<TomlTable>(element.value)) continue;
        Visit(element, key, shown + "[" + std::to_string(i) + "]");
      }
    }
  }

 private:
  [[noreturn]] void Refuse(const Rule& rule, const TomlValue& value,
                           const std::string& shown) const {
    std::string message = "this version does not have this feature yet (" + ValueText(value) + ")";
    message.append("; ").append(rule.remedy);
    FailAt(document_, value.place, shown, message);
  }

  const TomlDocument& document_;
};

}  // namespace

void RefuseNotYet(const TomlDocument& document) { Walk(document).Visit(document.root, "", ""); }

}  // namespace hpdm
