#pragma once

#include <string>
#include <vector>

namespace hpdm {

/// Runs a program (a path, or a name to look up in PATH, and its arguments), without its output if
/// `quiet`, and waits for it. Its exit code; -1 when it ended in another way. Throws MachineError
/// (the program, why) when it cannot be started. Main thread, loops ended.
int RunChild(const std::vector<std::string>& words, bool quiet = true);

}  // namespace hpdm
