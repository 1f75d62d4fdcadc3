#pragma once

#include <string_view>

#include "engine/base/types.h"

namespace hpdm {

/// Returns the CPU time that the hypervisor has taken since the machine started, summed over the
/// processors. It rises in steps of the kernel's clock tick (10 ms) and is 0 if the host does not
/// report it. Reads /proc/stat: not for a thread with a deadline. Never throws.
Nanoseconds StolenTime() noexcept;

/// Returns the same from the text of /proc/stat. Its first line, "cpu user nice system idle iowait
/// irq softirq steal ...", counts clock ticks of 1 / `ticks_per_second` s.
Nanoseconds StolenTimeIn(std::string_view proc_stat, long ticks_per_second) noexcept;

}  // namespace hpdm
