#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"
#include "render/camera/laparoscope_options.h"

namespace hpdm {

/// Overlays of the picture; or-ed.
enum Overlay : std::uint32_t {
  kOverlayNone = 0,
  kOverlayForce = 1u << 0,     ///< Contact force as colour on the organs.
  kOverlayContacts = 1u << 1,  ///< Contact vertices.
  kOverlayLattice = 1u << 2,   ///< The control lattice.
  kOverlayError = 1u << 3,     ///< Distance from the reference solution's surface, where one is
                               ///< loaded.
  kOverlayText = 1u << 4,      ///< Force, depth, loop health, frame rate.
};

/// The force with the last colour of kOverlayForce, N; gentle presses and grasps stay below.
inline constexpr double kForceScale = 2;

/// The trainee's settings of the view: window -> render loop, latest value, one triple buffer.
struct ViewSettings {
  LaparoscopeOptions scope;
  std::uint32_t overlays = kOverlayNone;
  bool help = false;              ///< Show the list of keys.
  bool guidance = true;           ///< Show what an exercise asks for next.
  bool click_takes = false;       ///< Show the hint that a click takes the active instrument.
  bool has_reference = false;     ///< kOverlayError has a reference.
  bool has_exercise = false;      ///< The scene has one, which can restart.
  bool paused = false;            ///< Show "PAUSED".
  bool recording = false;         ///< Write frames.
  std::uint64_t screenshots = 0;  ///< Number of requests so far.
  int active_instrument = 0;      ///< The instrument that the mouse moves.
  std::array<int, kMaxInstruments> wanted_instrument{};  ///< As SessionControl::instrument_index.
  int window_width = 0;   ///< px, of the window's framebuffer; 0 without a window.
  int window_height = 0;  ///< px.
  bool operator==(const ViewSettings&) const = default;
};

}  // namespace hpdm
