#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <span>

#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Largest number of points of a curve.
inline constexpr std::size_t kMaxCurvePoints = 3000;

/// Returns the data that the page's script draws, in SI units except where mm is stated. Curves are
/// thinned so that every peak stays: a run of samples becomes its smallest and its largest one.
///
///     start, duration, limit, pauses: [[from, to]], events: [{time, severity, name}],
///     hands: [{name, force: {times, values}, depth_mm: {times, values},
///              contacts: [[from, to, organ]],
///              path: {x, y, z, force}}]        mm, null between two segments
///     organ_names: [name] by index
///     organs: [{name, vertices, triangles}]    base64 of int16 (0.1 mm) and uint32 triples
///     organs_left_out: [name]
///     latencies: [{name, bins: [[upper_us, count]]}]
nlohmann::ordered_json PageData(const SessionReading& reading);

/// A thinned curve: times and values of at most `most` points, in order. Two curves over the same
/// samples may have different times.
struct ThinnedCurve {
  std::vector<double> times, values;
};
ThinnedCurve Thin(std::span<const float> values, double period, std::size_t most);

}  // namespace hpdm
