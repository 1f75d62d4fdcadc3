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
  /// s, by organ: time after the last touch until it is back at its position before any touch (0:
  /// in the first step without a touch). Empty if the model does not guarantee this.
  std::vector<std::optional<double>> settles;
  /// By organ: the number of its group, which is the first organ of it. Organs of one group can push
  /// each other, so a tool on one may move them all. Empty: each organ is alone.
  std::vector<std::size_t> pushing = {};
  /// True if nothing drives organs: all work comes from the hands, and from the energy of free organs.
  bool still = true;
};

/// A condition judged over a whole session.
struct Invariant {
  std::string name;           ///< Short and stable, for programs.
  std::string what;           ///< The value that must not exceed `bound`, for people.
  std::string unit;           ///< Unit of `worst` and `bound`; empty for a pure number.
  double worst = 0;           ///< Largest value found.
  double bound = 0;           ///< Largest permitted value.
  std::uint64_t checked = 0;  ///< Number of values.
  std::uint64_t broken = 0;   ///< Values beyond the bound, or not a number.
  std::optional<double> first = std::nullopt;  ///< s: session time of the first value beyond the
                                               ///< bound.

  bool Holds() const { return broken == 0; }
};

/// Reads a session's log and judges every tick, step and shape in it:
///
///   finite   numbers of any message that are not finite
///   ticks    periods that are neither a tick in the log, with its input and, where the log is not
///            thinned (output_thinning.h), its output, nor skipped with a cause
///   steps    steps that are missing, or whose input or first use goes backwards in time
///   force    length of a force on the hand over the device's limit
///   slew     its change from tick to tick over the device's limit; in a thinned log the mean
///            change since the last output. A switched-off force is exempt (force_guard.h), and so
///            is a change across a lost tick
///   energy   share of the work put into a contact that the hands got back beyond it: of the displayed
///            force, which energy tank and passivity controller limit, from the first touch of any tool until all have been free for 0.1 s.
///            Organs that something holds are then at rest, so friction can only make it negative. What free
///            organs have given away of the energy of their motion and weight counts as put in. A tool that
///            loses its place for a tick does not end the contact. Judged under the condition of
///            `work`, from 0.1 mJ put in. A contact in which jaws hold is exempt: they do work
///            themselves, and tissue that they let go keeps what it had stored. So is one with a
///            lost or skipped tick, a pause, a restart of the exercise, or a tick whose output a thinned log leaves out
///   work     W given to all hands together, the mean between two contact-free moments at least
///            a second apart, less what free organs have given away. It would be energy from nothing; judged
///            only if nothing drives organs (SessionLimits::still). A late patch gives tenths of a milliwatt. Jaws that
///            close on pressed tissue give millijoules each time. A contact that chatters by 1 mm
///            at 30 Hz gives a hand of 5 N s/m 89 mW
///   rest     m, distance of a control point, local function or indentation from its value before
///            any touch. Judged on organs that no tool has touched for SessionLimits::settles, nor
///            any organ that can push them
///
///   damage   largest fall of an attachment's damage, freed area or dissipated energy from one step
///            to the next, over its value before. Tears never heal, but where an exercise restarts
///
/// With `period` > 0, the session's hands repeat their motion every `period`:
///
///   repeats  N, difference of a force from that of the second period, from the third period
///            (start-up is in the first); 0 if it is the same bit for bit. Motions that differ
///            are not repetitions and count as broken. In a thinned log only forces at the same
///            time of the period are compared
///
/// Messages that cannot be read are skipped; CheckLog counts them. Throws InputError if the file
/// cannot be read.
std::vector<Invariant> CheckInvariants(const std::string& log, const SessionLimits& limits,
                                       Nanoseconds period = 0);

}  // namespace hpdm
