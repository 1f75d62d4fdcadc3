#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// Values of a scene that the invariants of its sessions need, by index.
struct SessionLimits {
  struct Tool {
    double max_force = 0;  ///< N, length of the force on the hand.
    double slew = 0;       ///< N, largest change in a tick.
  };
  std::vector<Tool> tools;
  /// s, by organ: after so long without a touch it is where it was before any touch (0: in the
  /// first step without a touch). Empty if the model does not guarantee this.
  std::vector<std::optional<double>> settles;
  bool still = true;  ///< True if no organ moves by itself: all work comes from the hands.
};

/// A condition judged over a whole session.
struct Invariant {
  std::string name;           ///< Short and stable, for programs.
  std::string what;           ///< The value that must not exceed `bound`, for people.
  std::string unit;           ///< Of `worst` and `bound`; empty: a number.
  double worst = 0;           ///< Largest value found.
  double bound = 0;           ///< Largest permitted value.
  std::uint64_t checked = 0;  ///< Values.
  std::uint64_t broken = 0;   ///< Values beyond the bound, or not a number.
  std::optional<double> first = std::nullopt;  ///< s: session time of the first of those.

  bool Holds() const { return broken == 0; }
};

/// Reads a session's log and judges every tick, step and shape in it:
///
///   finite   numbers of any message that are not finite
///   ticks    periods that are neither a tick in the log, with what went in and what came out, nor
///            skipped with a cause
///   steps    steps that are missing, or whose input or first use goes back in time
///   force    length of a force on the hand over the device's limit
///   slew     its change from tick to tick over the device's limit; a switched-off force is
///            exempt (force_guard.h), and so is what stands across a tick that the log lost
///   stored   J that the lattice has given out: -1/2 of the sum over the tips of force on the
///            tissue times displacement of the contact, which is the energy of a small strain and
///            must not be negative
///   work     W that the hands together were given on average between two moments, a second or
///            more apart, at which no tip touches anything: energy from nowhere, where nothing
///            but the hands works (SessionLimits::still). A late patch gives tenths of a
///            milliwatt, jaws that close on pressed tissue millijoules each time; a contact that
///            chatters by 1 mm at 30 Hz gives a hand of 5 N s/m 89 mW
///   rest     m, by which a control point, local function or indentation of an organ that no tool
///            touches, nor has touched for SessionLimits::settles, is not where it was before any
///            touch
///
/// and, with `period` > 0, of a session whose hands do the same again every `period`:
///
///   repeats  N, by which a force differs from that of the second period, from the third on
///            (start-up is in the first); 0 where it is the same bit for bit. Motions that differ
///            are no repetition and count as broken.
///
/// Messages that cannot be read are skipped: CheckLog counts them. Throws InputError where the
/// file cannot be read.
std::vector<Invariant> CheckInvariants(const std::string& log, const SessionLimits& limits,
                                       Nanoseconds period = 0);

}  // namespace hpdm
