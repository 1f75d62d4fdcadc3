#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenes/loader/key_form.h"

namespace hpdm {

/// All keys and values that the loader can accept in one table of a scene file. Its checks of
/// several keys together, other than those here, have no form.
struct TableForm {
  /// The forms of each key, one of which its value must have; never empty.
  std::map<std::string, std::vector<KeyForm>, std::less<>> keys;
  std::set<std::string, std::less<>> required;
  std::set<std::pair<std::string, std::string>> exclusive;  ///< At most one of the two.
};

/// Returns the forms of all tables by their paths as in kSceneTables. They come from the loader's
/// readers themselves, which read a scene that has every table.
std::map<std::string, TableForm, std::less<>> SceneKeyForms();

}  // namespace hpdm
