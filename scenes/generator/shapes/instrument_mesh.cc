#include "scenes/generator/shapes/instrument_mesh.h"

#include <array>
#include <utility>

#include "engine/base/angle.h"
#include "engine/base/check.h"
#include "scenes/generator/shapes/solid_builder.h"

namespace hpdm {
namespace {

using Ring = SolidBuilder::Ring;

constexpr double kMm = 1e-3;
constexpr double kShaftLength = 0.3;

Vector3d Mm(double x, double y, double z) { return Vector3d(x, y, z) * kMm; }

/// Returns a ring about the z axis.
Ring ShaftRing(double radius, double z, int count, bool half_step = false) {
  return SolidBuilder::Circle({0, 0, z}, Vector3d::UnitX(), Vector3d::UnitY(), radius, count,
                              half_step);
}

// Jaws and blades, in millimetres. The first one lies at x > 0; the second is its counterpart,
// turned by half a turn about z.

/// A jaw's rear end: a plate beside the other jaw's plate, between the prongs of the fork, from
/// `pivot` - 3.1 to `pivot` + 2.
struct Tang {
  struct Station {
    double z, half_width;
  };
  static constexpr double kNear = 0.05, kFar = 1.15;  // y

  explicit Tang(double pivot)
      : stations{{{pivot - 3.1, 1.9}, {pivot, 1.9}, {pivot + 1.3, 1.5}, {pivot + 2, 0.7}}} {}

  std::array<Station, 4> stations;
};

/// Returns the steel end of the shaft with the fork that carries the jaws on a pin. It has two
/// prongs, two heads of the pin, and the shaft, whose insulation begins at `pivot` + 9.5.
SurfaceMesh ForkedShaft(double pivot) {
  constexpr int kSegments = 12;
  constexpr double kGap = 0.02;  // keeps the solids apart
  SolidBuilder solid;
  const double collar = pivot + 4, insulation = pivot + 9.5;
  std::vector<Ring> rings;
  for (const auto& [radius, z] : {std::pair{2.2, collar},
                                  {2.42, collar + 0.3},
                                  {2.42, insulation - 0.1},
                                  {2.5, insulation + 0.1},
                                  {2.5, kShaftLength / kMm}}) {
    rings.push_back(ShaftRing(radius * kMm, z * kMm, kSegments));
  }
  solid.AddTube(rings, Mm(0, 0, collar), {0, 0, kShaftLength});

  for (const double side : {-1.0, 1.0}) {
    // From the slot outwards: the prong's outer face follows the shaft's circle.
    std::vector<Ring> prong;
    constexpr std::array<std::array<double, 2>, 2> kLayers = {{{1.2, 2.05}, {2.2, 1.1}}};
    for (const auto& [y, half_width] : kLayers) {
      Ring layer;
      const std::array<double, 7> x = {1, 1, 0.71, 0, -0.71, -1, -1};
      const std::array<double, 7> z = {collar - kGap, pivot, pivot - 1.5,  pivot - 2.1,
                                       pivot - 1.5,   pivot, collar - kGap};
      for (std::size_t i = 0; i < x.size(); ++i) {
        layer.points.push_back(Mm(side * x[i] * half_width, side * y, z[i]));
      }
      prong.push_back(layer);
    }
    solid.AddTube(prong, Mm(0, side * kLayers.front()[0], pivot),
                  Mm(0, side * kLayers.back()[0], pivot));
    std::vector<Ring> head;
    for (const double y : {2.2 + kGap, 2.42}) {
      head.push_back(SolidBuilder::Circle(Mm(0, side * y, pivot), Vector3d::UnitZ(),
                                          side * Vector3d::UnitX(), 0.75 * kMm, 6));
    }
    solid.AddTube(head, Mm(0, side * (2.2 + kGap), pivot), Mm(0, side * 2.42, pivot));
  }
  return solid.Mesh();
}

SurfaceMesh TurnedAboutZ(SurfaceMesh mesh) {
  mesh.vertices.leftCols<2>() *= -1;
  return mesh;
}

/// The back of a grasper's jaw at z.
struct Back {
  double z, height, half_width;
};
constexpr std::array<Back, 6> kBack = {{{-2.5, 0.6, 0.9},
                                        {-2.1, 1.1, 1.45},
                                        {-1, 1.55, 1.9},
                                        {2, 1.95, 2.2},
                                        {9.5, 2.25, 2.2},
                                        {11.6, 2.1, 2.2}}};

Back BackAt(double z) {
  std::size_t i = 0;
  while (i + 2 < kBack.size() && kBack[i + 1].z < z) ++i;
  const Back &low = kBack[i], &high = kBack[i + 1];
  const double part = (z - low.z) / (high.z - low.z);
  return Back{z, low.height + part * (high.height - low.height),
              low.half_width + part * (high.half_width - low.half_width)};
}

/// Lines along a grasper's jaw. They go around it from its flank at y > 0 over the back to the
/// other flank and to the face.
using JawLines = std::vector<std::vector<Vector3d>>;

/// Adds the toothed face, the flanks in half the height, and the back.
void AddGrip(bool second, JawLines* jaw) {
  JawLines& lines = *jaw;
  const auto add_face = [&](double x, double z) {
    const double half_width = BackAt(z).half_width;
    lines[5].push_back(Mm(x, half_width, z));
    lines[4].push_back(Mm(x, -half_width, z));
  };
  const auto add_flanks = [&](double z) {
    const Back at = BackAt(z);
    lines[0].push_back(Mm(0.55 * at.height, at.half_width, z));
    lines[3].push_back(Mm(0.55 * at.height, -at.half_width, z));
  };
  // Ridges across the face, whose crests lie in the valleys of the other jaw.
  constexpr int kTeeth = 6;
  constexpr double kHeight = 0.3, kClearance = 0.02, kFirstTooth = -1.7, kLastTooth = 10.7;
  add_face(kClearance, kBack.front().z);
  add_flanks(kBack.front().z);
  add_flanks(kBack[1].z);
  for (int i = 0; i <= 2 * kTeeth; ++i) {
    const double z = kFirstTooth + (kLastTooth - kFirstTooth) * i / (2 * kTeeth);
    const bool crest = (i % 2 == 1) != second;
    add_face(kClearance + (crest ? -kHeight : kHeight), z);
    // A tooth meets a point of the flank just before its crest, so that no edge crosses a valley.
    if (crest) add_flanks(z - 0.3);
  }
  add_face(kClearance, kBack.back().z);
  add_flanks(kBack.back().z);
  for (const Back& at : kBack) {
    lines[1].push_back(Mm(at.height, 0.5 * at.half_width, at.z));
    lines[2].push_back(Mm(at.height, -0.5 * at.half_width, at.z));
  }
}

/// Adds the neck and the tang, which lies at y > 0 and reaches to both sides of the axis.
void AddTang(double pivot, JawLines* lines) {
  const auto add = [lines](double z, double low, double high) {
    const std::array<double, 6> x = {low + 0.5 * (high - low), high, high,
                                     low + 0.5 * (high - low), low,  low};
    constexpr std::array<double, 6> kY = {Tang::kFar,  Tang::kFar,  Tang::kNear,
                                          Tang::kNear, Tang::kNear, Tang::kFar};
    for (std::size_t k = 0; k < lines->size(); ++k) (*lines)[k].push_back(Mm(x[k], kY[k], z));
  };
  add(pivot - 4, 0.05, 2);
  for (const Tang::Station& at : Tang(pivot).stations) add(at.z, -at.half_width, at.half_width);
}

/// Returns a grasper's jaw at x > 0 with the teeth of the first or the second.
SurfaceMesh GrasperJaw(double pivot, bool second) {
  JawLines lines(6);
  AddGrip(second, &lines);
  AddTang(pivot, &lines);
  // The bar's lines run counter-clockwise as seen from +z.
  SolidBuilder solid;
  solid.AddBar({lines[0], lines[5], lines[4], lines[3], lines[2], lines[1]});
  return solid.Mesh();
}

/// Returns a clip applier's jaw at x > 0: a bar with a channel for the leg of a clip, bent inwards at
/// its tip.
SurfaceMesh ClipJaw(double pivot) {
  struct Section {
    double z, face, back, half_width;
  };
  constexpr std::array<Section, 12> kSections = {{{-2.5, 0.1, 0.7, 0.6},
                                                  {-2.3, 0.05, 1.0, 0.85},
                                                  {-1.7, 0.05, 1.25, 1.0},
                                                  {-1.2, 0.3, 1.4, 1.05},
                                                  {0.5, 0.35, 1.5, 1.1},
                                                  {2.5, 0.35, 1.55, 1.15},
                                                  {4.5, 0.35, 1.6, 1.2},
                                                  {6.5, 0.35, 1.65, 1.2},
                                                  {8.0, 0.35, 1.7, 1.2},
                                                  {9.5, 0.3, 1.75, 1.2},
                                                  {10.5, 0.2, 1.8, 1.2},
                                                  {11.5, 0.1, 1.9, 1.2}}};
  JawLines lines(6);
  for (const Section& at : kSections) {
    const double w = at.half_width, mid = 0.5 * (at.face + at.back);
    const std::array<double, 6> x = {mid, at.back, at.back, mid, at.face, at.face};
    const std::array<double, 6> y = {w, 0.6 * w, -0.6 * w, -w, -0.7 * w, 0.7 * w};
    for (std::size_t k = 0; k < lines.size(); ++k) lines[k].push_back(Mm(x[k], y[k], at.z));
  }
  AddTang(pivot, &lines);
  SolidBuilder solid;
  solid.AddBar({lines[0], lines[5], lines[4], lines[3], lines[2], lines[1]});
  return solid.Mesh();
}

/// Returns a blade of the scissors: the first at y above the shear plane, the second below.
SurfaceMesh ScissorsBlade(double pivot, bool second) {
  // The x of the cutting edge and of the back on the shear plane, and the thickness beside it.
  struct Section {
    double z, edge, back, thickness;
  };
  const double neck = pivot - 4;
  const std::array<Section, 10> sections = {{{-2.5, 0.02, 0.4, 0.3},
                                             {-2.35, -0.12, 0.62, 0.5},
                                             {-1.9, -0.24, 0.85, 0.68},
                                             {-1, -0.3, 1.02, 0.8},
                                             {1, -0.32, 1.2, 0.9},
                                             {4, -0.34, 1.42, 1.0},
                                             {7, -0.36, 1.64, 1.06},
                                             {10, -0.38, 1.84, 1.1},
                                             {13, -0.4, 1.98, 1.1},
                                             {neck, -0.4, 2.05, 1.1}}};
  std::vector<std::vector<Vector3d>> lines(5);
  // The shear plane bends away from the shaft's axis by up to 2 mm at the tip.
  const auto add = [&](double z, const std::array<double, 5>& x, const std::array<double, 5>& y) {
    const double ahead = z < neck ? (neck - z) / (neck + 2.5) : 0;
    const double turn = second ? -1 : 1;
    for (std::size_t k = 0; k < lines.size(); ++k) {
      lines[k].push_back(Mm(turn * x[k], turn * y[k] + 2 * ahead * ahead, z));
    }
  };
  for (const Section& at : sections) {
    const double t = at.thickness, ridge = at.edge + 0.55 * (at.back - at.edge);
    add(at.z, {at.edge, at.back, at.back - 0.1, ridge, at.edge + 0.05},
        {0.01, 0.01, 0.6 * t, t, 0.4 * t});
  }
  for (const Tang::Station& at : Tang(pivot).stations) {
    const double w = at.half_width;
    add(at.z, {-w, w, w, 0, -w}, {Tang::kNear, Tang::kNear, Tang::kFar, Tang::kFar, Tang::kFar});
  }
  SolidBuilder solid;
  solid.AddBar(lines);
  return solid.Mesh();
}

InstrumentMeshes Grasper() {
  constexpr double kPivot = 16.5;
  return {.rigid = ForkedShaft(kPivot),
          .jaws = {GrasperJaw(kPivot, false), TurnedAboutZ(GrasperJaw(kPivot, true))},
          .pivot = kPivot * kMm,
          .opening = 30 * kDegree,
          .insulated_from = (kPivot + 9.5) * kMm};
}

InstrumentMeshes ClipApplier() {
  constexpr double kPivot = 16.5;
  return {.rigid = ForkedShaft(kPivot),
          .jaws = {ClipJaw(kPivot), TurnedAboutZ(ClipJaw(kPivot))},
          .pivot = kPivot * kMm,
          .opening = 20 * kDegree,
          .insulated_from = (kPivot + 9.5) * kMm};
}

InstrumentMeshes Scissors() {
  constexpr double kPivot = 19.5;
  return {.rigid = ForkedShaft(kPivot),
          .jaws = {ScissorsBlade(kPivot, false), ScissorsBlade(kPivot, true)},
          .pivot = kPivot * kMm,
          .opening = 22 * kDegree,
          .insulated_from = (kPivot + 9.5) * kMm};
}

InstrumentMeshes Hook() {
  constexpr int kWire = 16, kShaft = 16;
  constexpr double kFoot = -2, kBend = 1.3, kInsulation = 8;  // mm
  std::vector<Ring> rings;
  // Adds a ring of the wire from the foot's end through the bend. `turn` is the fraction of a turn
  // of its direction from -x towards +z.
  const auto wire = [&rings](double x, double z, double radius, double turn) {
    const auto [cosine, sine] = CosineSine(turn);
    rings.push_back(SolidBuilder::Circle(Mm(x, 0, z), Vector3d(sine, 0, cosine), Vector3d::UnitY(),
                                         radius * kMm, kWire));
  };
  wire(3.55, kFoot, 0.3, 0);
  wire(3.35, kFoot, 0.5, 0);
  for (int i = 0; i <= 5; ++i) {
    const auto [cosine, sine] = CosineSine(i / 20.0);
    wire(kBend - kBend * sine, kFoot + kBend - kBend * cosine, 0.5, i / 20.0);
  }
  wire(0, kInsulation - 0.05, 0.5, 0.25);
  wire(0, kInsulation, 0.95, 0.25);
  wire(0, kInsulation + 0.3, 1.1, 0.25);
  for (const auto& [radius, z] :
       {std::pair{1.1, 13.5}, {1.6, 14.6}, {2.2, 15.8}, {2.5, 17.0}, {2.5, kShaftLength / kMm}}) {
    rings.push_back(ShaftRing(radius * kMm, z * kMm, kShaft));
  }
  SolidBuilder solid;
  solid.AddTube(rings, Mm(3.6, 0, kFoot), {0, 0, kShaftLength});
  return {.rigid = solid.Mesh(), .jaws = {}, .insulated_from = (kInsulation - 0.025) * kMm};
}

}  // namespace

SurfaceMesh ProbeMesh() {
  // 281 vertices in rings from the tip to the end: with a pole at both ends, 562 triangles.
  constexpr int kSegments = 16;
  std::vector<Ring> rings;
  // Latitudes of the tip, as fractions of a turn from the pole. The ring of nine makes the total
  // 281.
  const auto add_latitude = [&rings](int count, double turns, bool half_step) {
    const std::array<double, 2> latitude = CosineSine(turns);
    rings.push_back(ShaftRing(kInstrumentRadius * latitude[1], -kInstrumentRadius * latitude[0],
                              count, half_step));
  };
  add_latitude(9, 26.0 / 360, false);
  add_latitude(kSegments, 48.0 / 360, false);
  add_latitude(kSegments, 69.0 / 360, true);
  // Along the shaft, the first rings are as far apart as the triangles are wide; later ones are
  // farther apart.
  constexpr int kShaftRings = 15;
  double z = 0, step = 0.9e-3;
  for (int i = 0; i + 1 < kShaftRings; ++i) {
    rings.push_back(ShaftRing(kInstrumentRadius, z, kSegments, i % 2 == 1));
    z += step;
    step *= 1.4;
  }
  HPDM_CHECK(z < kShaftLength);
  rings.push_back(ShaftRing(kInstrumentRadius, kShaftLength, kSegments, true));
  SolidBuilder solid;
  solid.AddTube(rings, {0, 0, -kInstrumentRadius}, {0, 0, kShaftLength});
  return solid.Mesh();
}

InstrumentMeshes MakeInstrument(InstrumentType type) {
  switch (type) {
    case InstrumentType::kProbe:
    case InstrumentType::kSuction:  // a tube whose openings are too small to be drawn
      break;
    case InstrumentType::kGrasper:
      return Grasper();
    case InstrumentType::kScissors:
      return Scissors();
    case InstrumentType::kHook:
      return Hook();
    case InstrumentType::kClipApplier:
      return ClipApplier();
  }
  return {.rigid = ProbeMesh(), .jaws = {}};
}

}  // namespace hpdm
