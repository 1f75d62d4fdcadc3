#pragma once

#include <string>

namespace hpdm {

/// Returns the JSON Schema (draft 7) of scene files, for editors: every table and key with its type
/// and limits as the loader's readers state them (SceneKeyForms), and with its default and meaning
/// from scenes/README.md. The schema refuses no scene that the loader accepts.
std::string SceneSchema();

}  // namespace hpdm
