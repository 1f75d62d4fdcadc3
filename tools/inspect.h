#pragma once

#include <CLI/CLI.hpp>

namespace hpdm {

/// Adds `hpdm inspect MESH [--unit m|mm|X] [--json]`: imports a mesh, mends it and prints what it
/// is and what had to be mended. Parsing the command line runs it; InputError (bad mesh or unit)
/// passes through to the caller, who prints it and exits with 2.
void AddInspectCommand(CLI::App& app);

}  // namespace hpdm
