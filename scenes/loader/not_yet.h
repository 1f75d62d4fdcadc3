#pragma once

#include "scenes/loader/toml_document.h"

namespace hpdm {

/// Throws InputError at the first key or value whose feature this version does not have: the
/// schema knows it, but to ignore it would run another scene than the one written. The list is the
/// table in not_yet.cc.
void RefuseNotYet(const TomlDocument& document);

}  // namespace hpdm
