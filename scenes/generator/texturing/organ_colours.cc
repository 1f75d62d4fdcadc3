#include "scenes/generator/texturing/organ_colours.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>

#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/shapes/solid_noise.h"
#include "scenes/generator/shapes/vessel_tree.h"

namespace hpdm {
namespace {

double DistanceToLine(const std::vector<Vector3d>& line, const Vector3d& p) {
  double least = (line.front() - p).norm();
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector3d along = line[i] - line[i - 1];
    const double t = std::clamp((p - line[i - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (line[i - 1] + t * along - p).norm());
  }
  return least;
}

/// Returns short vessels that leave a line every `spacing` (m) to its front and back, bent
/// `inwards` (m, to the line's right). They are the branches of an arcade that enter an organ.
std::vector<std::vector<Vector3d>> Branches(const std::vector<Vector3d>& line, double spacing,
                                            double inwards) {
  std::vector<std::vector<Vector3d>> branches;
  double left_over = spacing / 2;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector3d along = line[i] - line[i - 1];
    const double length = along.norm();
    for (; left_over < length; left_over += spacing) {
      const Vector3d start = line[i - 1] + along * (left_over / length);
      const Vector3d right = Vector3d(along.y(), -along.x(), 0) * (inwards / length);
      for (const double side : {1.0, -1.0}) {
        branches.push_back({start, start + right + Vector3d(0, 0, side * 0.012)});
      }
    }
    left_over -= length;
  }
  return branches;
}

std::vector<std::vector<Vector3d>> Joined(std::vector<std::vector<Vector3d>> first,
                                          const std::vector<std::vector<Vector3d>>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

class LiverColours {
 public:
  LiverColours() : vessels_(*shape_, Trunks(), kVessels) {}

  Vector3d At(const Vector3d& p) const {
    const double patches = FractalNoise(p / 0.05, 3, 1), mottle = FractalNoise(p / 0.012, 2, 5);
    Vector3d colour = Mix({0.43, 0.20, 0.165}, {0.345, 0.14, 0.13},
                          SmoothStep(-0.2, 0.9, patches + 0.35 * mottle));
    colour = Mix(colour, {0.50, 0.26, 0.20}, 0.6 * SmoothStep(0.1, 0.9, -patches + 0.3 * mottle));
    // Thin tissue is paler: `below` is close to zero where the point 12 mm below lies near the
    // other side.
    const Vector3d normal = shape_->Sample(p).gradient.normalized();
    const double below = shape_->Sample(p - 0.012 * normal).value;
    colour = Mix(colour, {0.60, 0.38, 0.29}, 0.5 * SmoothStep(-0.0095, -0.002, below));
    const CellSample lobule = CellNoise(p / 0.0026, 9);
    colour *= 1 + 0.13 * (0.5 - lobule.nearest) + 0.05 * (lobule.shade - 0.5);
    return Mix(colour, {0.28, 0.08, 0.09}, 0.45 * vessels_.Coverage(p, kSpot));
  }

 private:
  // A texel of the fine liver.
  static constexpr double kSpot = 0.5e-3;
  static constexpr VesselOptions kVessels = {.targets = 260,
                                             .step = 2.5e-3,
                                             .sight = 0.03,
                                             .reached = 4e-3,
                                             .finest_radius = 0.2e-3,
                                             .seed = 3};

  /// Places where vessels of the ligaments enter the capsule.
  static std::vector<std::vector<Vector3d>> Trunks() {
    return {{Vector3d(0.045, 0.035, 0.05), Vector3d(0.04, 0.02, 0.055)},
            {Vector3d(-0.06, 0.04, 0.05), Vector3d(-0.055, 0.03, 0.055)},
            {Vector3d(-0.02, -0.07, 0.03), Vector3d(-0.022, -0.06, 0.04)}};
  }

  const std::unique_ptr<ImplicitShape> shape_ = LiverShape();
  VesselTree vessels_;
};

class StomachColours {
 public:
  StomachColours()
      : greater_(StomachGreaterCurvature()),
        lesser_(StomachLesserCurvature()),
        arteries_(*shape_, Trunks(0.026), Vessels(4)),
        veins_(*shape_, Trunks(0.031), Vessels(5)) {}

  Vector3d At(const Vector3d& p) const {
    const double patches = FractalNoise(p / 0.04, 3, 11), mottle = FractalNoise(p / 0.006, 2, 15);
    Vector3d colour =
        Mix({0.76, 0.52, 0.46}, {0.68, 0.40, 0.365}, SmoothStep(-0.1, 0.9, patches + 0.2 * mottle));
    colour = Mix(colour, {0.82, 0.62, 0.55}, 0.7 * SmoothStep(0.0, 0.9, -patches + 0.25 * mottle));
    colour *= 1 + 0.025 * mottle;
    // A vein runs beside each artery, deeper under the serosa.
    const Vector3d wound =
        p + 0.0008 * Vector3d(GradientNoise(p / 0.006, 21), GradientNoise(p / 0.006, 22),
                              GradientNoise(p / 0.006, 23));
    colour = Mix(colour, {0.43, 0.20, 0.26}, 0.6 * veins_.Coverage(wound, kSpot));
    colour = Mix(colour, {0.58, 0.12, 0.11}, 0.85 * arteries_.Coverage(wound, kSpot));
    const double ragged = 0.007 * FractalNoise(p / 0.018, 3, 31);
    const double fat = std::max(SmoothStep(0.016, 0.010, DistanceToLine(greater_, p) + ragged),
                                SmoothStep(0.011, 0.006, DistanceToLine(lesser_, p) + ragged));
    return Mix(colour, FatColour(p), 0.93 * fat);
  }

 private:
  static constexpr double kSpot = 0.5e-3;
  static VesselOptions Vessels(std::uint64_t seed) {
    return {.targets = 900,
            .step = 2e-3,
            .sight = 0.05,
            .reached = 3e-3,
            .finest_radius = 0.26e-3,
            .seed = seed};
  }

  std::vector<std::vector<Vector3d>> Trunks(double spacing) const {
    return Joined(Branches(greater_, spacing, 0.006), Branches(lesser_, spacing, -0.006));
  }

  const std::unique_ptr<ImplicitShape> shape_ = StomachShape();
  std::vector<Vector3d> greater_, lesser_;
  VesselTree arteries_, veins_;
};

class GallbladderColours {
 public:
  GallbladderColours(const ImplicitShape& shape, const Vector3d& neck)
      : neck_(neck), vessels_(shape, Trunks(neck), kVessels) {}

  Vector3d At(const Vector3d& p) const {
    const double patches = FractalNoise(p / 0.016, 3, 41), mottle = FractalNoise(p / 0.003, 2, 45);
    const double from_neck = (p - neck_).norm();
    Vector3d colour =
        Mix({0.31, 0.36, 0.28}, {0.25, 0.33, 0.31}, SmoothStep(-0.5, 0.7, patches + 0.2 * mottle));
    colour = Mix(colour, {0.38, 0.37, 0.24}, 0.5 * SmoothStep(0.1, 0.9, -patches));
    // The wall is thicker and its bile shows less towards the neck.
    colour = Mix(colour, {0.56, 0.43, 0.35}, 0.75 * SmoothStep(0.045, 0.012, from_neck));
    colour *= 1 + 0.03 * mottle;
    colour = Mix(colour, {0.42, 0.10, 0.10}, 0.75 * vessels_.Coverage(p, kSpot));
    const double ragged = 0.014 * FractalNoise(p / 0.012, 3, 51);
    return Mix(colour, FatColour(p / 0.6), 0.85 * SmoothStep(0.016, 0.005, from_neck + ragged));
  }

 private:
  static constexpr double kSpot = 0.15e-3;
  static constexpr VesselOptions kVessels = {.targets = 650,
                                             .step = 0.8e-3,
                                             .sight = 0.015,
                                             .reached = 0.9e-3,
                                             .finest_radius = 0.08e-3,
                                             .seed = 6};

  /// The cystic artery's branches along both sides of the body.
  static std::vector<std::vector<Vector3d>> Trunks(const Vector3d& neck) {
    return {{neck + Vector3d(0.006, 0, 0.002), neck + Vector3d(0.009, -0.02, 0.006)},
            {neck + Vector3d(-0.004, 0, -0.004), neck + Vector3d(-0.008, -0.022, 0.003)}};
  }

  Vector3d neck_;
  VesselTree vessels_;
};

/// Returns an organ's colours as a function whose copies share one Organ, because growing the
/// vessels is slow.
template <typename Organ, typename... Arguments>
SurfaceColour ColourOf(const Arguments&... arguments) {
  return [organ = std::make_shared<const Organ>(arguments...)](const Vector3d& p) {
    return organ->At(p);
  };
}

/// A smooth wall between two tones, with fine vessels where a noise changes its sign.
SurfaceColour WallColour(const Vector3d& light, const Vector3d& dark, double size,
                         std::uint32_t seed) {
  return [=](const Vector3d& p) {
    const double patches = FractalNoise(p / size, 3, seed);
    const double web = std::abs(GradientNoise(p / (0.5 * size), seed + 1)) +
                       0.4 * std::abs(GradientNoise(p / (0.2 * size), seed + 2));
    const Vector3d wall = Mix(light, dark, SmoothStep(-0.5, 0.7, patches));
    return Mix(wall, {0.58, 0.18, 0.17}, 0.4 * SmoothStep(0.14, 0.0, web));
  };
}

}  // namespace

Vector3d FatColour(const Vector3d& p) {
  const Vector3d bent =
      p + 0.002 * Vector3d(GradientNoise(p / 0.005, 71), GradientNoise(p / 0.005, 72),
                           GradientNoise(p / 0.005, 73));
  const CellSample lobule = CellNoise(bent / 0.0065, 70);
  const double cleft = 1 - SmoothStep(0.0, 0.55, lobule.second - lobule.nearest);
  const double tone = 0.5 + 0.5 * FractalNoise(p / 0.014, 2, 75) + 0.35 * (lobule.shade - 0.5);
  const Vector3d yellow = Mix({0.80, 0.60, 0.31}, {0.88, 0.73, 0.46}, std::clamp(tone, 0.0, 1.0));
  return Mix(yellow, {0.74, 0.46, 0.26}, 0.45 * cleft * cleft);
}

SurfaceColour LiverColour() { return ColourOf<LiverColours>(); }
SurfaceColour StomachColour() { return ColourOf<StomachColours>(); }
SurfaceColour GallbladderColour() {
  return GallbladderColour(*GallbladderShape(), GallbladderNeck());
}
SurfaceColour GallbladderColour(const ImplicitShape& shape, const Vector3d& neck) {
  return ColourOf<GallbladderColours>(shape, neck);
}
SurfaceColour DuctColour() {
  return WallColour({0.66, 0.60, 0.42}, {0.52, 0.52, 0.33}, 0.010, 151);
}
SurfaceColour ArteryColour() {
  return WallColour({0.74, 0.36, 0.32}, {0.63, 0.22, 0.20}, 0.008, 161);
}
SurfaceColour NodeColour() {
  return WallColour({0.69, 0.50, 0.42}, {0.56, 0.36, 0.32}, 0.004, 171);
}

}  // namespace hpdm
