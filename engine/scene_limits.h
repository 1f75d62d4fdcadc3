#pragma once

/// Largest numbers of what a scene has. Values that the threads exchange have room for them.
namespace hpdm {

inline constexpr int kMaxInstruments = 4;
inline constexpr int kMaxOrgans = 64;
inline constexpr int kMaxAttachments = 8;
inline constexpr int kMaxDucts = 8;
inline constexpr int kMaxLayers = 16;  ///< Of all organs.
inline constexpr int kMaxLumens = 16;  ///< Filled ones of all organs.
inline constexpr int kMaxHeld = 8;     ///< Instruments that one hand can take in turn.
/// Places where one tip can press at once, on different organs or on one.
inline constexpr int kMaxPlaces = 3;
/// Places where one shaft can press at once, on different organs or apart on one.
inline constexpr int kShaftPlaces = 2;
/// All places of a tool: first those of the tip, then those of the shaft.
inline constexpr int kToolPlaces = kMaxPlaces + kShaftPlaces;

}  // namespace hpdm
