#include "scenes/generator/texturing/abdomen_picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/check.h"
#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/shapes/solid_noise.h"
#include "scenes/generator/shapes/vessel_tree.h"
#include "scenes/generator/texturing/organ_colours.h"

namespace hpdm {
namespace {

// Frame: origin at the lens, x to the right, y up, z forwards; m.

/// Half the picture's height at the distance 1: 65 degrees from top to bottom.
constexpr double kHalfHeight = 0.637;

enum class Tissue { kWall, kFat, kBowel };

struct Nearest {
  double distance;
  Tissue tissue;
};

Vector3d Square(const Vector3d& v) { return v.cwiseProduct(v); }

/// The shapes behind the organs, seen from inside.
class Abdomen {
 public:
  /// Returns a lower bound of the distance to the nearest shape; a rough shape may be twice as far.
  Nearest At(const Vector3d& p) const {
    Nearest nearest{-cavity_.Sample(p).value + 0.003 * GradientNoise(p / 0.035, 115),
                    Tissue::kWall};
    const auto consider = [&nearest](double distance, Tissue tissue) {
      if (distance < nearest.distance) nearest = {distance, tissue};
    };
    consider(Fat(p), Tissue::kFat);
    for (const Loop& loop : loops_) {
      // The field of a distant shape need not be exact.
      double distance = (p - loop.middle).norm() - loop.reach;
      if (distance < 0.02)
        distance = 0.8 * (loop.shape.Sample(p).value + loop.creases * Creases(p));
      consider(distance, Tissue::kBowel);
    }
    return nearest;
  }

  Vector3d Normal(const Vector3d& p) const {
    constexpr double kStep = 4e-4;
    Vector3d slope;
    for (int d = 0; d < 3; ++d) {
      const Vector3d step = kStep * Vector3d::Unit(d);
      slope[d] = At(p + step).distance - At(p - step).distance;
    }
    const double length = slope.norm();
    return length > 0 ? Vector3d(slope / length) : Vector3d(0, 0, -1);
  }

  /// Returns the sRGB colour.
  Vector3d Colour(const Vector3d& p, Tissue tissue) const {
    const double patches = FractalNoise(p / 0.06, 3, 101), mottle = FractalNoise(p / 0.012, 2, 105);
    const Vector3d bent =
        p + 0.003 * Vector3d(GradientNoise(p / 0.02, 106), GradientNoise(p / 0.02, 107),
                             GradientNoise(p / 0.02, 108));
    switch (tissue) {
      case Tissue::kFat: {
        const Vector3d fat = FatColour(p / 1.6) * (1.02 + 0.10 * patches);
        return Mix(Mix(fat, {0.84, 0.56, 0.42}, 0.25 + 0.3 * SmoothStep(0.0, 0.8, patches)),
                   {0.62, 0.17, 0.14},
                   0.6 * fat_vessels_.Coverage(ProjectToLevel(heap_, bent, 0), kSpot));
      }
      case Tissue::kBowel: {
        const Vector3d serosa =
            Mix({0.89, 0.68, 0.60}, {0.83, 0.55, 0.49}, SmoothStep(-0.5, 0.7, patches));
        // Fine vessels show as lines where a noise changes its sign.
        const double web = std::abs(GradientNoise(bent / 0.012, 141)) +
                           0.4 * std::abs(GradientNoise(bent / 0.005, 142));
        return Mix(serosa, {0.66, 0.27, 0.27}, 0.35 * SmoothStep(0.16, 0.0, web));
      }
      case Tissue::kWall:
        break;
    }
    // Muscle behind the peritoneum; the dome's middle is its pale tendon.
    const Vector3d tendon = Vector3d(0.02, 0.10, 0.29);
    const double fibres = FractalNoise({p.x() / 0.005, p.y() / 0.04, p.z() / 0.04}, 2, 111);
    Vector3d wall = Mix({0.78, 0.49, 0.42}, {0.66, 0.35, 0.31}, SmoothStep(-0.5, 0.7, patches));
    wall *= 1 + 0.07 * fibres;
    const double pale = SmoothStep(0.11, 0.04, (p - tendon).norm() + 0.03 * patches);
    wall = Mix(wall, {0.86, 0.68, 0.60}, 0.6 * pale);
    // A little fat shines through.
    wall = Mix(wall, {0.88, 0.70, 0.48}, 0.35 * SmoothStep(0.2, 0.9, -patches + 0.2 * mottle));
    return Mix(wall, {0.52, 0.17, 0.19},
               0.65 * wall_vessels_.Coverage(ProjectToLevel(cavity_, bent, 0), kSpot));
  }

 private:
  static constexpr double kSpot = 0.9e-3;  // about a pixel of half the size

  struct Loop {
    Loop(double creases_m, const std::vector<SweptBall::Node>& nodes)
        : creases(creases_m), shape(nodes) {
      const Bounds box = shape.bounds();
      middle = 0.5 * (box.min + box.max);
      reach = 0.5 * (box.max - box.min).norm();
    }
    double creases;  ///< m: depth of the haustra and folds.
    SweptBall shape;
    Vector3d middle;
    double reach;
  };

  double Fat(const Vector3d& p) const {
    const double base = heap_.Sample(p).value;
    if (base > 0.03) return base - 0.02;
    const Vector3d bent =
        p + 0.006 * Vector3d(GradientNoise(p / 0.02, 121), GradientNoise(p / 0.02, 122),
                             GradientNoise(p / 0.02, 123));
    const double folds = FractalNoise(p / 0.05, 2, 125);
    const CellSample lobe = CellNoise(bent / 0.022, 120), lobule = CellNoise(bent / 0.008, 124);
    const double relief = 0.012 * folds + 0.008 * (0.6 - lobe.nearest * lobe.nearest) +
                          0.0022 * (0.6 - lobule.nearest * lobule.nearest);
    return 0.6 * (base - relief);
  }

  /// The bowel's haustra and folds, -1 to 1.
  static double Creases(const Vector3d& p) { return GradientNoise(p / 0.022, 131); }

  static VesselOptions Vessels(double sight, int targets, std::uint64_t seed) {
    return {.targets = targets,
            .step = 4e-3,
            .sight = sight,
            .reached = 8e-3,
            .finest_radius = 0.32e-3,
            .seed = seed};
  }

  const Ellipsoid cavity_{Vector3d(0, 0.02, 0.13), Vector3d(0.21, 0.135, 0.20)};
  const Ellipsoid heap_{Vector3d(0.0, -0.33, 0.19), Vector3d(0.34, 0.275, 0.34), Vector3d::UnitX(),
                        Vector3d(0, 1, -0.12)};
  const std::vector<Loop> loops_ = {
      // The transverse colon, across, with its haustra.
      Loop(0.006, {{{-0.20, -0.010, 0.16}, 0.024},
                   {{-0.15, -0.030, 0.19}, 0.024},
                   {{-0.09, -0.052, 0.215}, 0.022},
                   {{-0.03, -0.072, 0.22}, 0.022},
                   {{0.04, -0.070, 0.225}, 0.022},
                   {{0.10, -0.046, 0.22}, 0.024},
                   {{0.15, -0.022, 0.19}, 0.024},
                   {{0.20, 0.005, 0.16}, 0.023}}),
      // Small bowel, in front on both sides.
      Loop(0.002, {{{-0.20, -0.060, 0.09}, 0.014},
                   {{-0.14, -0.057, 0.105}, 0.0145},
                   {{-0.095, -0.062, 0.125}, 0.014},
                   {{-0.085, -0.068, 0.155}, 0.014},
                   {{-0.12, -0.062, 0.170}, 0.014},
                   {{-0.17, -0.045, 0.160}, 0.014}}),
      Loop(0.002, {{{-0.16, -0.080, 0.065}, 0.014},
                   {{-0.10, -0.070, 0.085}, 0.0145},
                   {{-0.06, -0.073, 0.095}, 0.014},
                   {{-0.035, -0.085, 0.085}, 0.014},
                   {{-0.045, -0.095, 0.065}, 0.014}}),
      Loop(0.002, {{{0.20, -0.050, 0.10}, 0.014},
                   {{0.15, -0.054, 0.11}, 0.0145},
                   {{0.11, -0.064, 0.13}, 0.014},
                   {{0.115, -0.062, 0.165}, 0.014},
                   {{0.16, -0.045, 0.165}, 0.014}}),
      Loop(0.002, {{{0.17, -0.085, 0.07}, 0.014},
                   {{0.11, -0.072, 0.085}, 0.0145},
                   {{0.08, -0.076, 0.105}, 0.014},
                   {{0.055, -0.09, 0.10}, 0.014}})};
  const VesselTree wall_vessels_{cavity_,
                                 {{{-0.12, 0.10, 0.04}, {-0.10, 0.11, 0.08}},
                                  {{0.12, 0.10, 0.04}, {0.10, 0.11, 0.08}},
                                  {{-0.17, 0.0, 0.22}, {-0.15, 0.04, 0.25}},
                                  {{0.17, 0.0, 0.22}, {0.15, 0.04, 0.25}}},
                                 Vessels(0.08, 500, 7)};
  const VesselTree fat_vessels_{heap_,
                                {{{-0.05, -0.07, 0.20}, {-0.05, -0.07, 0.18}},
                                 {{0.0, -0.07, 0.20}, {0.01, -0.07, 0.18}},
                                 {{0.06, -0.07, 0.20}, {0.06, -0.07, 0.18}}},
                                Vessels(0.06, 2500, 8)};
};

/// Returns the linear light from one direction.
Vector3d LightFrom(const Abdomen& abdomen, const Vector3d& direction) {
  constexpr int kSteps = 90;
  constexpr double kNear = 0.035, kHit = 2e-4;
  double depth = kNear;
  Nearest nearest = abdomen.At(depth * direction);
  for (int step = 0; step < kSteps && nearest.distance > kHit; ++step) {
    depth += 0.8 * nearest.distance;
    nearest = abdomen.At(depth * direction);
  }
  const Vector3d p = depth * direction;
  const Vector3d normal = abdomen.Normal(p);
  // Light comes from slightly above the lens; crevices get less of the scattered light.
  const Vector3d to_light = (Vector3d(0, 0.02, 0) - p).normalized();
  const double facing = std::max(0.0, normal.dot(to_light));
  double open = 1;
  for (const double reach : {0.004, 0.012, 0.03}) {
    open -= 0.3 * std::clamp(1 - abdomen.At(p + reach * normal).distance / reach, 0.0, 1.0);
  }
  const Vector3d halfway = (to_light - direction).normalized();
  double gloss = std::max(0.0, normal.dot(halfway));
  for (int power = 1; power < 64; power *= 2) gloss *= gloss;
  const Vector3d albedo = Square(abdomen.Colour(p, nearest.tissue));
  const double fall_off = 0.16 / (0.06 + depth);
  const Vector3d scattered = albedo.cwiseProduct(Vector3d(0.32, 0.25, 0.23)) * open;
  return (scattered + albedo * (1.05 * facing * (0.35 + 0.65 * open)) +
          Vector3d::Constant(0.45 * gloss)) *
         fall_off;
}

using Picture = std::vector<Vector3d>;

/// Averages over 2 `reach` + 1 pixels along rows, then along columns.
void Blur(int width, int height, int reach, Picture* picture) {
  const auto pass = [&](int length, int lines, int along, int across) {
    std::vector<Vector3d> line(static_cast<std::size_t>(length));
    for (int l = 0; l < lines; ++l) {
      const auto at = [&](int i) -> Vector3d& {
        return (*picture)[static_cast<std::size_t>(l * across + i * along)];
      };
      for (int i = 0; i < length; ++i) {
        Vector3d sum = Vector3d::Zero();
        for (int j = i - reach; j <= i + reach; ++j) sum += at(std::clamp(j, 0, length - 1));
        line[static_cast<std::size_t>(i)] = sum / (2 * reach + 1);
      }
      for (int i = 0; i < length; ++i) at(i) = line[static_cast<std::size_t>(i)];
    }
  };
  pass(width, height, 1, width);
  pass(height, width, width, 1);
}

}  // namespace

Image AbdomenPicture(int width, int height) {
  HPDM_CHECK(width >= 2 && height >= 2);
  // The picture is out of focus, so half the pixels suffice.
  const int w = (width + 1) / 2, h = (height + 1) / 2;
  const Abdomen abdomen;
  Picture light;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const double right = (2 * x + 1 - w) * kHalfHeight / h;
      const double up = (h - 2 * y - 1) * kHalfHeight / h;
      light.push_back(LightFrom(abdomen, Vector3d(right, up, 1).normalized()));
    }
  }
  // Two passes approximate a lens's blur; its width is a fixed fraction of the picture.
  const int reach = std::max(0, w / 200);
  for (int pass = 0; pass < 2; ++pass) Blur(w, h, reach, &light);
  Image image{width, height, {}};
  image.rgb.reserve(static_cast<std::size_t>(3 * width * height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto at = [&](int i, int j) {
        return light[static_cast<std::size_t>(std::clamp(j, 0, h - 1) * w +
                                              std::clamp(i, 0, w - 1))];
      };
      const int i = x / 2, j = y / 2, i2 = i + (x % 2 == 0 ? -1 : 1),
                j2 = j + (y % 2 == 0 ? -1 : 1);
      const Vector3d colour = (9 * at(i, j) + 3 * at(i2, j) + 3 * at(i, j2) + at(i2, j2)) / 16;
      for (int k = 0; k < 3; ++k) {
        // The square root is close to sRGB's curve and has the same bits on every machine.
        const double component = std::clamp(std::sqrt(colour[k]), 0.0, 1.0);
        image.rgb.push_back(static_cast<std::uint8_t>(std::lround(component * 255)));
      }
    }
  }
  return image;
}

}  // namespace hpdm
