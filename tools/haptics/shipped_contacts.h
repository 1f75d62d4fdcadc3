#pragma once

#include <filesystem>
#include <vector>

#include "tools/haptics/contact_loop.h"

namespace hpdm {

/// Loads a scene for measurements of its contacts, with another rate or delay if they are given.
/// Throws InputError.
///   haptic_hz: ticks a second; 0: the scene's.
///   delay: s, of every device, in addition to the hold; below 0: the scene's.
std::shared_ptr<const Session> ContactSession(const std::filesystem::path& scene, int haptic_hz,
                                              double delay);

/// Returns the contacts of a scene: each probe presses each organ, and each grasper holds the organ
/// of its hand. A hand's own organ is touched at the hand's target, another one where the straight
/// shaft meets it most squarely past all others; an organ that the shaft does not reach has no
/// contact.
///
/// Reference pose: 5 mm deep, but at most 1 N (a rigid organ: 2 N). A grasp closes 2 mm deep and
/// pulls as far or as hard along the outward normal. The tip comes there through the session's own
/// loops and rests for half a second.
std::vector<ShippedContact> FindContacts(const std::shared_ptr<const Session>& session);

}  // namespace hpdm
