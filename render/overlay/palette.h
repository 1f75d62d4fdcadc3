#pragma once

#include <Eigen/Core>

#include "render/overlay/status_text.h"

namespace hpdm {

/// Colours that carry meaning in the picture: the tones of the status text and the force bar. The colour
/// maps (colour_map.h) suit all readers already, and the marks of contacts differ in shape.
///
///   kStandard     cyan, amber, red; the bar is green, amber, red
///   kColourBlind  sky blue, yellow and vermillion of Okabe and Ito (2008) for both. Alarms have "! "
///                 before them besides.
///
/// With full deuteranopia green and red of the standard bar are 12 apart in CIELAB; in kColourBlind all
/// pairs of tones for good, warning and alarm are more than 30 apart for every kind of dichromacy
/// (status_text_test.cc, after Machado et al. 2009).
enum class Palette { kStandard, kColourBlind };

using TextColour = Eigen::Vector4f;  ///< sRGB and opacity.

TextColour ColourOf(Tone tone, Palette palette);

/// Returns the colour of the force bar: good, a warning from two thirds of the force limit on, or an
/// alarm above it. `fraction`: StatusLine::bar.
TextColour BarColour(double fraction, Palette palette);

}  // namespace hpdm
