#include "tools/report/page/page_data.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tools/report/metrics/session_files.h"
#include "tools/shared/base64.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

/// Largest number of vertices in the page, over all organs.
constexpr Eigen::Index kMaxVertices = 60'000;
constexpr std::size_t kMaxEvents = 200;
constexpr std::size_t kMaxBands = 3000;  // of contacts, and of pauses
constexpr std::size_t kMaxLatencyBins = 2000;

/// Rounds to thousandths, which are finer than a screen shows and short as text.
double Thousandths(double value) {
  return std::isfinite(value) ? std::round(value * 1000) / 1000 : 0;
}

Json Curve(const ThinnedCurve& curve, double start) {
  Json times = Json::array(), values = Json::array();
  for (const double time : curve.times) times.push_back(Thousandths(start + time));
  for (const double value : curve.values) values.push_back(Thousandths(value));
  return {{"times", std::move(times)}, {"values", std::move(values)}};
}

/// Returns contacts as [from, to, organ], s. Contacts too close for a screen are joined.
Json Contacts(const std::vector<SessionTimeSeries::Peaks>& peaks, double start) {
  const double blur =
      static_cast<double>(peaks.size()) * kMotionPeriod / static_cast<double>(kMaxCurvePoints);
  Json contacts = Json::array();
  double from = 0, to = 0;
  int organ = -1;
  const auto close = [&] {
    if (organ < 0 || contacts.size() == kMaxBands) return;
    contacts.push_back({Thousandths(start + from), Thousandths(start + to), organ});
  };
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    if (peaks[i].organ < 0) continue;
    const double time = static_cast<double>(i) * kMotionPeriod;
    if (peaks[i].organ != organ || time - to > blur) {
      close();
      organ = peaks[i].organ;
      from = time;
    }
    to = time + kMotionPeriod;
  }
  close();
  return contacts;
}

struct Path {
  Json x = Json::array(), y = Json::array(), z = Json::array(), force = Json::array();
  void Add(const Vector3d& p, double f) {
    x.push_back(std::lround(p.x() * 1e4) / 10.0);
    y.push_back(std::lround(p.y() * 1e4) / 10.0);
    z.push_back(std::lround(p.z() * 1e4) / 10.0);
    force.push_back(std::lround(f * 100) / 100.0);
  }
  void Break() {
    for (Json* array : {&x, &y, &z, &force}) array->push_back(nullptr);
  }
};

/// Adds points at least `step` m apart, each with the largest force since the previous one. Returns
/// their number. `path` may be null.
std::size_t Walk(const std::vector<TimeSeriesSegment>& segments, double step, Path* path) {
  std::size_t count = 0;
  for (const TimeSeriesSegment& segment : segments) {
    if (path != nullptr && count > 0) path->Break();
    const std::size_t samples = segment.samples.size();
    Vector3d last = Vector3d::Zero();
    double force = 0;
    for (std::size_t i = 0; i < samples; ++i) {
      const Vector3d p = segment.samples[i].segment<3>(kMotionTip);
      force = std::max(force, segment.samples[i].segment<3>(kMotionForce).norm());
      if (i > 0 && i + 1 < samples && (p - last).norm() < step) continue;
      if (path != nullptr) path->Add(p, force);
      last = p;
      force = 0;
      ++count;
    }
  }
  return count;
}

Json PathOf(const std::vector<TimeSeriesSegment>& segments) {
  double step = 2e-4;
  // Each segment has two points at least, so a large step does not bound their number.
  while (step < 0.1 && Walk(segments, step, nullptr) > kMaxCurvePoints) step *= 1.3;
  Path path;
  if (Walk(segments, step, nullptr) <= 2 * kMaxCurvePoints) Walk(segments, step, &path);
  return {{"x", path.x}, {"y", path.y}, {"z", path.z}, {"force", path.force}};
}

Json OrganOf(const OrganDescription& organ) {
  std::vector<std::int16_t> vertices;
  for (Eigen::Index i = 0; i < organ.vertices.size(); ++i) {
    const double tenths = std::clamp(organ.vertices.data()[i] * 1e4, -32767.0, 32767.0);
    vertices.push_back(static_cast<std::int16_t>(std::lround(tenths)));
  }
  const std::vector<std::uint32_t> triangles(organ.triangles.data(),
                                             organ.triangles.data() + organ.triangles.size());
  return {
      {"name", organ.name}, {"vertices", Base64Of(vertices)}, {"triangles", Base64Of(triangles)}};
}

}  // namespace

ThinnedCurve Thin(std::span<const float> values, double period, std::size_t most) {
  ThinnedCurve curve;
  const auto add = [&](std::size_t i) {
    curve.times.push_back(static_cast<double>(i) * period);
    curve.values.push_back(values[i]);
  };
  const std::size_t width = std::max<std::size_t>(1, (2 * values.size() + most - 1) / most);
  for (std::size_t begin = 0; begin < values.size(); begin += width) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last =
        values.begin() + static_cast<std::ptrdiff_t>(std::min(begin + width, values.size()));
    const auto [low, high] = std::minmax_element(first, last);
    add(static_cast<std::size_t>(std::min(low, high) - values.begin()));
    if (low != high) add(static_cast<std::size_t>(std::max(low, high) - values.begin()));
  }
  return curve;
}

Json PageData(const SessionReading& reading) {
  const SessionReport& report = reading.report;
  const double start = reading.series.start;
  Json data = {{"start", start}, {"duration", report.duration}, {"limit", report.force_limit}};
  data["depth_limit_mm"] = Thousandths(1000 * report.depth_limit);
  data["pauses"] = Json::array();
  for (const auto& [from, to] : reading.series.pauses) {
    if (data["pauses"].size() == kMaxBands) break;
    data["pauses"].push_back({Thousandths(from), Thousandths(to)});
  }
  data["events"] = Json::array();
  for (const SessionEvent& event : report.events) {
    if (data["events"].size() == kMaxEvents) break;
    data["events"].push_back({{"time", event.time},
                              {"severity", static_cast<int>(event.severity)},
                              {"name", event.name}});
  }
  data["hands"] = Json::array();
  for (std::size_t h = 0; h < report.hands.size(); ++h) {
    const SessionTimeSeries::Hand& hand = reading.series.hands[h];
    std::vector<float> forces, depths;
    for (const SessionTimeSeries::Peaks& peak : hand.peaks) {
      forces.push_back(peak.force);
      depths.push_back(1000 * peak.depth);
    }
    data["hands"].push_back(
        {{"name", report.hands[h].Label()},
         {"force", Curve(Thin(forces, kMotionPeriod, kMaxCurvePoints), start)},
         {"depth_mm", Curve(Thin(depths, kMotionPeriod, kMaxCurvePoints), start)},
         {"contacts", Contacts(hand.peaks, start)},
         {"path", PathOf(hand.segments)}});
  }
  data["organ_names"] = report.organs;
  data["organs"] = Json::array();
  data["organs_left_out"] = Json::array();
  Eigen::Index vertices = 0;
  for (const OrganDescription& organ : reading.series.organs) {
    if (vertices + organ.vertices.rows() > kMaxVertices) {
      data["organs_left_out"].push_back(organ.name);
      continue;
    }
    vertices += organ.vertices.rows();
    data["organs"].push_back(OrganOf(organ));
  }
  data["latencies"] = Json::array();
  for (const LatencyReport& latency : report.latencies) {
    if (latency.count == 0 || latency.bins.size() > kMaxLatencyBins) continue;
    Json bins = Json::array();
    for (const auto& [upper, count] : latency.bins) {
      bins.push_back({static_cast<double>(upper) / 1000, count});
    }
    data["latencies"].push_back({{"name", latency.name}, {"bins", std::move(bins)}});
  }
  return data;
}

}  // namespace hpdm
