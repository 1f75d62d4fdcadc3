#include "scenes/generator/anatomy/anatomy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "scenes/generator/anatomy/anatomy_scene.h"
#include "scenes/generator/shapes/solid_builder.h"

namespace hpdm {
namespace {

/// An anatomy with its questions.
struct Patient {
  Patient(AnatomyVariant variant, std::uint64_t seed) : anatomy(variant, seed) {}

  /// The field of the gallbladder at a point of the world, m.
  double FromGallbladder(const Vector3d& p) const {
    const auto [c, s] = CosineSine(-Anatomy::kTiltTurns);
    const Vector3d q = p - anatomy.gallbladder_position;
    return anatomy.gallbladder.shape->Sample({q.x(), c * q.y() - s * q.z(), s * q.y() + c * q.z()})
        .value;
  }
  double From(const std::string& organ, const Vector3d& p) const {
    if (organ == "gallbladder") return FromGallbladder(p);
    for (const Anatomy::Organ& other : anatomy.fixed) {
      if (other.name == organ) return other.shape->Sample(p).value;
    }
    ADD_FAILURE() << organ;
    return 0;
  }

  Anatomy anatomy;
};

using Variant = std::pair<std::string_view, AnatomyVariant>;

/// Five patients of each variant.
class AnatomyOf : public testing::TestWithParam<Variant> {
 protected:
  AnatomyOf() {
    for (const std::uint64_t seed : {0u, 1u, 2u, 3u, 41u}) {
      patients_.emplace_back(GetParam().second, seed);
    }
  }
  std::vector<Patient> patients_;
};

INSTANTIATE_TEST_SUITE_P(Variants, AnatomyOf, testing::ValuesIn(kAnatomyVariants),
                         [](const auto& of) { return std::string(of.param.first); });

/// Returns points every quarter of a millimetre on a polyline, m.
std::vector<Vector3d> Along(const std::vector<Vector3d>& path) {
  std::vector<Vector3d> points = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vector3d way = path[i] - path[i - 1];
    const int steps = static_cast<int>(way.norm() / 0.25e-3) + 1;
    for (int k = 1; k <= steps; ++k) points.push_back(path[i - 1] + way * (1.0 * k / steps));
  }
  return points;
}

double Length(const std::vector<Vector3d>& path) {
  double length = 0;
  for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
  return length;
}

TEST_P(AnatomyOf, TubesEndInTheTissueOfTheirOrgans) {
  for (const Patient& patient : patients_) {
    for (const Anatomy::Tube& tube : patient.anatomy.tubes) {
      for (const auto& [organ, end] :
           {std::pair(tube.a, tube.path.front()), std::pair(tube.b, tube.path.back())}) {
        EXPECT_LT(patient.From(organ, end), -0.4e-3) << tube.name << " in " << organ;
        EXPECT_GT(patient.From(organ, end), -1.5e-3) << tube.name << " in " << organ;
      }
    }
  }
}

TEST_P(AnatomyOf, TubesKeepClearOfEverythingButTheirEnds) {
  const auto liver = LiverShape();
  for (const Patient& patient : patients_) {
    for (const Anatomy::Tube& tube : patient.anatomy.tubes) {
      for (const Vector3d& p : Along(tube.path)) {
        EXPECT_GT(liver->Sample(p).value, tube.radius + 5e-3) << tube.name;
        const bool beside_a = (p - tube.path.front()).norm() < 6e-3;
        const bool beside_b = (p - tube.path.back()).norm() < 8e-3;
        for (const char* organ : {"gallbladder", "bile duct", "hepatic artery", "lymph node"}) {
          if ((beside_a && organ == tube.a) || (beside_b && organ == tube.b)) continue;
          EXPECT_GT(patient.From(organ, p), tube.radius)
              << tube.name << " at " << p.transpose() << " in " << organ;
        }
      }
    }
  }
}

TEST_P(AnatomyOf, GallbladderLiesInItsFossaWithoutTouchingTheLiver) {
  const auto liver = LiverShape();
  for (const Patient& patient : patients_) {
    double gap = 1;
    int facing = 0;
    for (double x = -0.012; x < 0.028; x += 1e-3) {
      for (double y = -0.105; y < -0.055; y += 1e-3) {
        for (double z = 0; z < 0.045; z += 1e-3) {
          const Vector3d p(x, y, z);
          const double to_liver = liver->Sample(p).value;
          if (to_liver < -1e-3 || to_liver > 5e-3) continue;
          const double from_gallbladder = patient.FromGallbladder(p);
          if (std::abs(from_gallbladder) > 0.5e-3) continue;
          gap = std::min(gap, to_liver + from_gallbladder);
          facing += to_liver + from_gallbladder < 4e-3;
        }
      }
    }
    EXPECT_GT(gap, 0.3e-3);
    EXPECT_LT(gap, 2e-3);
    // About a point a square millimetre within the bed's reach.
    EXPECT_GT(facing, 500);
  }
}

TEST_P(AnatomyOf, LeafSpansTheWayBetweenNeckAndLiverOutsideBoth) {
  const auto liver = LiverShape();
  for (const Patient& patient : patients_) {
    const auto& [on_gallbladder, on_liver] = patient.anatomy.leaf;
    for (const Vector3d& p : on_gallbladder) EXPECT_NEAR(patient.FromGallbladder(p), 0, 0.1e-3);
    for (const Vector3d& p : on_liver) EXPECT_NEAR(liver->Sample(p).value, 0, 0.1e-3);
    for (const auto& [a, b] : {std::pair(on_gallbladder.front(), on_liver.front()),
                               std::pair(on_gallbladder.back(), on_liver.back())}) {
      EXPECT_GT((b - a).norm(), 0.010);
      EXPECT_LT((b - a).norm(), 0.030);
      for (const double t : {0.25, 0.5, 0.75}) {
        const Vector3d p = a + t * (b - a);
        EXPECT_GT(patient.FromGallbladder(p), 0) << t;
        EXPECT_GT(liver->Sample(p).value, -1e-3) << t;
      }
    }
  }
}

TEST_P(AnatomyOf, CysticDuctHasItsLength) {
  const auto [low, high] = GetParam().second == AnatomyVariant::kShortDuct ? std::pair(0.010, 0.020)
                           : GetParam().second == AnatomyVariant::kLowUnion
                               ? std::pair(0.050, 0.070)
                               : std::pair(0.026, 0.040);
  for (const Patient& patient : patients_) {
    const double length = Length(patient.anatomy.tubes[0].path);
    EXPECT_GT(length, low);
    EXPECT_LT(length, high);
  }
}

TEST_P(AnatomyOf, ArteryCrossesOnItsSideOfTheDuct) {
  for (const Patient& patient : patients_) {
    // Columns from back to front through both.
    int crossings = 0;
    for (double y = -0.056; y < -0.020; y += 1e-3) {
      for (double x = 0.015; x < 0.045; x += 1e-3) {
        double duct = 0, artery = 0;  // z in their middle
        double in_duct = 0, in_artery = 0;
        for (double z = -0.06; z < 0; z += 1e-3) {
          const double from_duct = patient.From("bile duct", {x, y, z});
          const double from_artery = patient.From("hepatic artery", {x, y, z});
          if (from_duct < in_duct) duct = z, in_duct = from_duct;
          if (from_artery < in_artery) artery = z, in_artery = from_artery;
        }
        if (in_duct > -1e-3 || in_artery > -1e-3) continue;
        ++crossings;
        EXPECT_EQ(artery > duct, GetParam().second == AnatomyVariant::kArteryInFront);
      }
    }
    EXPECT_GT(crossings, 0);
  }
}

TEST(Anatomy, TheGallbladderIsFreeAndNothingButBedLeafAndTubesHoldsIt) {
  const std::string text = AnatomySceneText(Anatomy(AnatomyVariant::kUsual, 0), "test");
  const std::size_t begins = text.find("name = \"gallbladder\"");
  const std::string organ = text.substr(begins, text.find("[[organ]]", begins) - begins);
  EXPECT_NE(organ.find("[organ.free]"), std::string::npos);
  EXPECT_EQ(organ.find("[[organ.support]]"), std::string::npos);
  EXPECT_NE(text.find("gravity = [0.0, 0.0, -9.81]"), std::string::npos);
}

TEST(Anatomy, SeedsAreRepeatableAndDiffer) {
  const auto text = [](std::uint64_t seed) {
    return AnatomySceneText(Anatomy(AnatomyVariant::kUsual, seed), "test");
  };
  EXPECT_EQ(text(5), text(5));
  EXPECT_NE(text(5), text(6));
}

}  // namespace
}  // namespace hpdm
