#pragma once

#include <cstdint>

namespace hpdm {

/// Faults of a clip, bits.
enum ClipFault : std::uint32_t {
  kClipSound = 0,
  kClipOblique = 1u << 0,    ///< Its plane is too far off the duct's normal plane.
  kClipShort = 1u << 1,      ///< The jaws do not cover the whole width of the lumen.
  kClipNearClip = 1u << 2,   ///< Too near to another clip.
  kClipNearEnd = 1u << 3,    ///< Too near to an end that stays in the body.
  kClipOnNothing = 1u << 4,  ///< It fell: no duct was between the jaws.
  kClipRefused = 1u << 5,    ///< It fell: the duct takes no clip there.
};

/// The faults of a clip and its measures.
struct ClipFinding {
  std::uint32_t faults = kClipSound;  ///< ClipFault.
  double angle = 0;                   ///< rad off the duct's normal plane.
  double most_angle = 0;              ///< rad: of a good clip.
  double coverage = 1;                ///< Share of the lumen's width between the jaws.
  double to_clip = 0;                 ///< m between its edge and the nearest clip's.
  double to_end = 0;                  ///< m between its edge and the nearest end that stays.
};

}  // namespace hpdm
