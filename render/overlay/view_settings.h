#pragma once

#include <cstdint>

#include "render/camera/laparoscope_options.h"

namespace hpdm {

/// What may be drawn over the picture; or-ed.
enum Overlay : std::uint32_t {
  kOverlayNone = 0,
  kOverlayForce = 1u << 0,     ///< Contact force as colour on the organs.
  kOverlayContacts = 1u << 1,  ///< Contact vertices.
  kOverlayLattice = 1u << 2,   ///< The control lattice.
  kOverlayError = 1u << 3,     ///< Distance from the reference solution's surface, where one is
                               ///< loaded.
  kOverlayText = 1u << 4,      ///< Force, depth, loop health, frame rate.
};

/// N: the force with the last colour of kOverlayForce; gentle presses and grasps stay below.
inline constexpr double kForceScale = 2;

/// What the trainee may change of the view while the session runs: window -> render loop, latest
/// value, one triple buffer.
struct ViewSettings {
  LaparoscopeOptions scope;
  std::uint32_t overlays = kOverlayNone;
  bool help = false;           ///< The keys are listed.
  bool click_takes = false;    ///< A click gives the mouse the active instrument: the text says so.
  bool has_reference = false;  ///< kOverlayError has something to show.
  bool paused = false;         ///< The picture says so.
  bool recording = false;      ///< Frames are kept.
  std::uint64_t screenshots = 0;  ///< Asked for so far.
  int active_instrument = 0;      ///< That the mouse moves.
  int window_width = 0;           ///< px, of the window's framebuffer; 0 without a window.
  int window_height = 0;          ///< px.
};

}  // namespace hpdm
