#pragma once

/// GLSL of what all materials share. Colours linear until Encode.
///
/// How a pixel gets its colour. The light at the scope's tip gives a surface at distance d the
/// irradiance (d0 / d)^2 cos^2(theta), with d0 the target's distance (a camera's automatic
/// exposure) and theta the angle off the viewing axis. Tissue reflects it diffusely, wrapped
/// around the terminator as light that scatters under the surface is (more of the red), and
/// specularly as a wet film: GGX (Walter et al. 2007) with Schlick's Fresnel term. Metal reflects
/// a red surrounding. The camera's tone curve and the optics' vignette follow.
///
/// Everything depends on positions alone (no time, no random numbers), so the same scene gives the
/// same pixels.
namespace hpdm::glsl {

extern const char* const kLight;   ///< Light, exposure, circle; needs kFrame.
extern const char* const kTissue;  ///< ShadeTissue(); needs kLight and kFrame.

}  // namespace hpdm::glsl
