#pragma once

#include <CLI/App.hpp>

namespace hpdm {

/// Registers `hpdm generate [NAMES...] --out DIR [--list]`: writes mesh assets (mesh_assets.h) as
/// DIR/NAME.obj, all that are kept in scenes/meshes when no name is given, and prints a line for
/// each. The work runs in the subcommand's callback, which throws InputError.
void AddGenerateCommand(CLI::App& app);

}  // namespace hpdm
