#pragma once

#include <string_view>

#include "engine/base/types.h"

namespace hpdm {

/// Time that a hypervisor has taken from this machine's processors since it started, summed over
/// them, in steps of the kernel's clock tick (10 ms). 0 where the host does not tell. Reads
/// /proc/stat: not for a thread with a deadline. Never throws.
Nanoseconds StolenTime() noexcept;

/// The same from the text of /proc/stat, whose first line counts clock ticks of
/// 1 / `ticks_per_second` s: "cpu user nice system idle iowait irq softirq steal ...".
Nanoseconds StolenTimeIn(std::string_view proc_stat, long ticks_per_second) noexcept;

}  // namespace hpdm
