#pragma once

/// GLSL 3.30 text of the picture's programs, in parts that ShaderProgram joins. World coordinates
/// in metres, colours linear until Encode.
///
/// How a pixel gets its colour. The light at the scope's tip gives a surface at distance d the
/// irradiance (d0 / d)^2 cos^2(theta), with d0 the target's distance (a camera's automatic
/// exposure) and theta the angle off the viewing axis. Tissue reflects it diffusely, wrapped
/// around the terminator as light that scatters under the surface is (more of the red), and
/// specularly as a wet film: GGX (Walter et al. 2007) with Schlick's Fresnel term. Metal reflects
/// a red surrounding. Exposure 1 - exp(-x) and the sRGB curve follow.
///
/// Everything depends on positions alone (no time, no random numbers), so the same scene gives the
/// same pixels.
namespace hpdm::glsl {

extern const char* const kFrame;         ///< Uniform block Frame (FrameUniforms in scene_view.cc).
extern const char* const kLight;         ///< Light, exposure, circle; needs kFrame.
extern const char* const kPattern;       ///< Value noise and bumps.
extern const char* const kTissue;        ///< ShadeTissue(); needs the three above.
extern const char* const kMeshVertex;    ///< Vertex stage of organs and instruments; needs kFrame.
extern const char* const kOrganMain;     ///< Fragment stage of an organ.
extern const char* const kMetalMain;     ///< Fragment stage of an instrument.
extern const char* const kCavityVertex;  ///< Vertex stage of the background: one triangle.
extern const char* const kCavityMain;    ///< Fragment stage of the background.
extern const char* const
    kSurroundVertex;  ///< The dark outside of the circle: a strip of triangles.
extern const char* const kSurroundMain;

}  // namespace hpdm::glsl
