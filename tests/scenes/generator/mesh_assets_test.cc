#include "scenes/generator/mesh_assets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "scenes/generator/meshing/surface_mesher.h"
#include "scenes/generator/shapes/implicit_shapes.h"
#include "scenes/generator/shapes/instrument_mesh.h"
#include "tests/support/mesh_checks.h"

namespace hpdm {
namespace {

std::string CommittedText(const std::string& name) {
  std::ifstream file(HPDM_SOURCE_DIR "/scenes/meshes/" + name + ".obj", std::ios::binary);
  EXPECT_TRUE(file) << name << ".obj is missing; run hpdm generate --out scenes/meshes";
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Reads the few forms that ObjText writes.
SurfaceMesh Committed(const std::string& name) {
  std::istringstream text(CommittedText(name));
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (std::string line; std::getline(text, line);) {
    std::istringstream row(line);
    std::string keyword, corner;
    row >> keyword;
    if (keyword == "v") {
      Vector3d p;
      row >> p[0] >> p[1] >> p[2];
      vertices.push_back(p);
    } else if (keyword == "f") {
      std::array<int, 3> t;
      for (int& v : t) {
        row >> corner;  // "v" or "v/vt"
        v = std::stoi(corner);
      }
      triangles.push_back(t);
    }
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(vertices.size(), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) mesh.vertices.row(v) = vertices[v];
  mesh.triangles.resize(triangles.size(), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = triangles[t][k] - 1;
  }
  return mesh;
}

/// Promised properties of each committed file. Sizes are x, y, z in metres, to 2 mm.
struct Promise {
  const char* name;
  int triangles;
  int components;
  double volume;            ///< m^3; relative tolerance below.
  double volume_tolerance;  ///< Relative.
  Vector3d size;            ///< m.
  double smallest_angle;    ///< Degrees: no triangle is below.
  double usual_angle;       ///< Degrees: 95 % of the triangles are above.
};

void PrintTo(const Promise& promise, std::ostream* out) { *out << promise.name; }

/// Volumes are the shapes' own (the mesher conserves them to 1e-4), sizes and angles as measured
/// when the shapes were settled, with room for a change of mesher. The probe's long triangles are
/// the shaft's: 300 mm of a tube of 16 mm around.
const Promise kPromises[] = {
    {"liver_274", 274, 1, 1.5e-3, 1e-3, {0.2125, 0.170, 0.1335}, 12, 20},
    {"liver_1332", 1332, 1, 1.5e-3, 1e-3, {0.213, 0.170, 0.134}, 15, 28},
    {"liver_5000", 5000, 1, 1.5e-3, 1e-3, {0.213, 0.170, 0.134}, 15, 35},
    {"stomach_2132", 2132, 1, 1.264e-3, 1e-3, {0.208, 0.240, 0.0995}, 20, 30},
    {"stomach_hollow", 3800, 2, 3.434e-4, 5e-3, {0.208, 0.240, 0.0995}, 18, 30},
    {"gallbladder", 1500, 2, 1.542e-5, 5e-3, {0.030, 0.080, 0.031}, 14, 27},
    {"bent_organ", 1600, 1, 3.739e-4, 1e-3, {0.0887, 0.203, 0.0443}, 15, 28},
    {"probe_562", 562, 1, 5.79e-6, 1e-2, {0.005, 0.005, 0.3025}, 0.4, 0.4},
    {"grasper", 224, 5, 5.27e-6, 1e-2, {0.005, 0.005, 0.286}, 0.05, 0.1},
    {"grasper_jaw_1", 176, 1, 1.28e-7, 2e-2, {0.0042, 0.0044, 0.021}, 1, 1},
    {"grasper_jaw_2", 180, 1, 1.29e-7, 2e-2, {0.0042, 0.0044, 0.021}, 1, 1},
    {"scissors", 224, 5, 5.2e-6, 1e-2, {0.005, 0.005, 0.283}, 0.05, 0.1},
    {"scissors_blade_1", 136, 1, 4.67e-8, 2e-2, {0.004, 0.0025, 0.024}, 1, 1},
    {"scissors_blade_2", 136, 1, 4.67e-8, 2e-2, {0.004, 0.0031, 0.024}, 1, 1},
    {"hook", 512, 1, 5.49e-6, 1e-2, {0.0061, 0.005, 0.3025}, 0.1, 0.1},
};

class MeshAsset : public testing::TestWithParam<Promise> {};

INSTANTIATE_TEST_SUITE_P(Committed, MeshAsset, testing::ValuesIn(kPromises),
                         [](const auto& promise) { return std::string(promise.param.name); });

TEST_P(MeshAsset, FileIsReproducedByteForByte) {
  const std::string name = GetParam().name;
  EXPECT_TRUE(MeshAssetObj(name, MakeMeshAsset(name)) == CommittedText(name))
      << "run hpdm generate --out scenes/meshes and look at the change";
}

TEST_P(MeshAsset, IsClosedManifoldOrientedAndFreeOfSelfIntersections) {
  const Promise promise = GetParam();
  const SurfaceMesh mesh = Committed(promise.name);
  EXPECT_EQ(mesh.triangles.rows(), promise.triangles);
  EXPECT_EQ(EdgeDefects(mesh), 0);
  const std::vector<int> component = Components(mesh);
  EXPECT_EQ(*std::max_element(component.begin(), component.end()) + 1, promise.components);
  EXPECT_EQ(EulerCharacteristic(mesh), 2 * promise.components);
  EXPECT_EQ(SelfIntersections(mesh), 0);
}

TEST_P(MeshAsset, HasItsVolumeSizeAndAngles) {
  const Promise promise = GetParam();
  const SurfaceMesh mesh = Committed(promise.name);
  EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles), promise.volume,
              promise.volume_tolerance * promise.volume);
  const Vector3d size = mesh.vertices.colwise().maxCoeff() - mesh.vertices.colwise().minCoeff();
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(size[k], promise.size[k], 2e-3);
  const std::vector<double> angles = SmallestAngles(mesh);
  EXPECT_GT(angles[0], promise.smallest_angle);
  EXPECT_GT(angles[angles.size() / 20], promise.usual_angle);
}

TEST(MeshAssets, LiverVerticesLieNearTheImplicitShape) {
  const auto shape = LiverShape();
  // The level that conserves the volume lies a mean sagitta outside the shape, edge^2 / (8 radius):
  // a quarter for half the edge length. On the border the field rises half as fast as the distance,
  // which doubles it there.
  const std::pair<const char*, double> bounds[] = {
      {"liver_274", 2e-3}, {"liver_1332", 5e-4}, {"liver_5000", 1.5e-4}};
  for (const auto& [name, bound] : bounds) {
    const SurfaceMesh mesh = Committed(name);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      const Vector3d p = mesh.vertices.row(v);
      EXPECT_LT((ProjectToLevel(*shape, p, 0) - p).norm(), bound) << name << " vertex " << v;
    }
  }
}

TEST(MeshAssets, LiversOfTwoSizesAreTheSameSurface) {
  const SurfaceMesh fine = Committed("liver_5000");
  for (const auto& [name, mean_bound, largest_bound] :
       {std::tuple{"liver_1332", 2e-4, 3e-3}, std::tuple{"liver_274", 1.2e-3, 1e-2}}) {
    const SurfaceMesh coarse = Committed(name);
    double sum = 0, largest = 0;
    int count = 0;
    for (Eigen::Index v = 0; v < fine.vertices.rows(); v += 3) {
      const double distance = DistanceToMesh(fine.vertices.row(v), coarse);
      sum += distance;
      largest = std::max(largest, distance);
      ++count;
    }
    // The mean is the sagitta of the coarse edges (12 and 26 mm) on the lobes; the largest is in
    // the fissure and the gallbladder's fossa, 10 and 28 mm wide, which the coarse edges span.
    EXPECT_LT(sum / count, mean_bound) << name;
    EXPECT_LT(largest, largest_bound) << name;
  }
}

TEST(MeshAssets, LargeLiversAreGeneratedAtTheirExactCount) {
  const SurfaceMesh mesh = MakeMeshAsset("liver_30000");
  EXPECT_EQ(mesh.triangles.rows(), 30000);
  EXPECT_EQ(EdgeDefects(mesh), 0);
  EXPECT_EQ(EulerCharacteristic(mesh), 2);
  EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles), 1.5e-3, 1e-3 * 1.5e-3);
  EXPECT_GT(SmallestAngles(mesh)[0], 20);
}

TEST(MeshAssets, OrgansAreCentredOnTheirVolume) {
  for (const char* name : {"liver_5000", "liver_1332", "stomach_2132"}) {
    const SurfaceMesh mesh = Committed(name);
    Vector3d moment = Vector3d::Zero();
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
      const auto& [a, b, c] = Corners(mesh, t);
      moment += a.dot(b.cross(c)) / 6 * (a + b + c) / 4;
    }
    // The shapes are centred to 10 um; a coarse mesh moves the centre by a fraction of its sagitta.
    EXPECT_LT((moment / EnclosedVolume(mesh.vertices, mesh.triangles)).norm(), 2e-4) << name;
  }
}

TEST(MeshAssets, LiverHasADomeAHollowUndersideAndASharpBorder) {
  const auto liver = LiverShape();
  const auto inside = [&liver](double x, double y, double z) {
    return liver->Sample(Vector3d(x, y, z)).value < 0;
  };
  // The right lobe is thick where the left one is thin.
  const auto thickness = [&inside](double x, double y) {
    int steps = 0;
    for (double z = -0.1; z < 0.1; z += 1e-3) steps += inside(x, y, z);
    return steps * 1e-3;
  };
  EXPECT_GT(thickness(-0.01, 0), 0.1);
  EXPECT_LT(thickness(0.11, 0.03), 0.06);
  // The underside is hollow: half-way between the right lobe's lower tip and the left lobe's tip,
  // both on the inferior border, there is no tissue.
  const SurfaceMesh mesh = Committed("liver_5000");
  Eigen::Index lower_tip = 0, left_tip = 0;
  mesh.vertices.col(1).minCoeff(&lower_tip);
  mesh.vertices.col(0).maxCoeff(&left_tip);
  const Vector3d between = 0.5 * (mesh.vertices.row(lower_tip) + mesh.vertices.row(left_tip));
  EXPECT_GT(liver->Sample(between).value, 0.01);
  // At the sharp border, the tissue 10 mm above it is thinner than 25 mm.
  double border = 0.05;
  while (thickness(0.09, border) > 0) border -= 1e-3;
  EXPECT_LT(thickness(0.09, border + 0.01), 0.025);
}

/// Distances of a hollow organ's cavity vertices to its outer surface.
void ExpectWall(const char* name, double wall, double thinnest, double thickest) {
  const SurfaceMesh mesh = Committed(name);
  const SurfaceMesh outer = Component(mesh, 0), cavity = Component(mesh, 1);
  EXPECT_GT(EnclosedVolume(outer.vertices, outer.triangles), 0);
  EXPECT_LT(EnclosedVolume(cavity.vertices, cavity.triangles), 0);
  const std::vector<int> component = Components(mesh);
  double sum = 0;
  int count = 0;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (component[v] != 1) continue;
    const double distance = DistanceToMesh(mesh.vertices.row(v), outer);
    EXPECT_GT(distance, thinnest) << name << " vertex " << v;
    EXPECT_LT(distance, thickest) << name << " vertex " << v;
    sum += distance;
    ++count;
  }
  EXPECT_NEAR(sum / count, wall, 0.05 * wall) << name;
}

TEST(MeshAssets, HollowOrgansHaveTheirWallEverywhere) {
  // Both surfaces follow their shape to a sagitta: edges of 9 mm on radii of 12 to 47 mm, of 4 mm
  // on 5 to 15 mm, so that a chord comes up to 0.8 mm nearer at the stomach's narrow ends.
  ExpectWall("stomach_hollow", 5e-3, 4.1e-3, 5.5e-3);
  ExpectWall("gallbladder", 3e-3, 2.6e-3, 3.2e-3);
}

TEST(MeshAssets, ProbeIsARoundedRodInTheToolFrame) {
  const SurfaceMesh mesh = Committed("probe_562");
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3d p = mesh.vertices.row(v);
    EXPECT_GT(p.z(), -0.0025 - 1e-6);
    EXPECT_LT(p.z(), 0.3 + 1e-6);
    if (p.z() > 0.3 - 1e-6) continue;  // The flat end.
    const Vector3d from_axis(p.x(), p.y(), std::min(p.z(), 0.0));
    // Files are rounded to the micrometre.
    EXPECT_NEAR(from_axis.norm(), 0.0025, 1e-6);
  }
}

/// The parts of an instrument with its jaws open by `jaw`, as one mesh.
SurfaceMesh WithJaws(const InstrumentMeshes& model, double jaw) {
  SurfaceMesh all = model.rigid;
  double angle = -model.opening * jaw;
  for (SurfaceMesh part : model.jaws) {
    const Vector3d pivot(0, 0, model.pivot);
    const Matrix3d R = Eigen::AngleAxisd(angle, Vector3d::UnitY()).toRotationMatrix();
    for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
      const Vector3d p = part.vertices.row(v);
      part.vertices.row(v) = pivot + R * (p - pivot);
    }
    all = Joined(all, part);
    angle = -angle;
  }
  return all;
}

TEST(MeshAssets, InstrumentsHaveAbout562TrianglesInAllTheirParts) {
  for (const InstrumentType type :
       {InstrumentType::kProbe, InstrumentType::kGrasper, InstrumentType::kScissors,
        InstrumentType::kHook, InstrumentType::kClipApplier}) {
    // The paper's number, to what whole teeth and segments allow.
    EXPECT_NEAR(WithJaws(MakeInstrument(type), 0).triangles.rows(), 562, 70);
  }
}

TEST(MeshAssets, JawsTurnWithoutTouchingEachOtherOrTheFork) {
  for (const double jaw : {0.0, 0.3, 1.0}) {
    EXPECT_EQ(SelfIntersections(WithJaws(MakeInstrument(InstrumentType::kGrasper), jaw)), 0) << jaw;
    EXPECT_EQ(SelfIntersections(WithJaws(MakeInstrument(InstrumentType::kScissors), jaw)), 0)
        << jaw;
    EXPECT_EQ(SelfIntersections(WithJaws(MakeInstrument(InstrumentType::kClipApplier), jaw)), 0)
        << jaw;
  }
}

TEST(MeshAssets, TipsOfInstrumentsLieInTheirBallWhenClosed) {
  for (const InstrumentType type : {InstrumentType::kGrasper, InstrumentType::kScissors,
                                    InstrumentType::kHook, InstrumentType::kClipApplier}) {
    const SurfaceMesh mesh = WithJaws(MakeInstrument(type), 0);
    EXPECT_NEAR(mesh.vertices.col(2).minCoeff(), -kInstrumentRadius, 1e-9);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
      const Vector3d p = mesh.vertices.row(v);
      if (p.z() > -1.9e-3) continue;
      // The tip touches an organ first; the hook's foot reaches 1.1 mm out of the ball.
      EXPECT_LT(p.head<2>().norm(), type == InstrumentType::kHook ? 3.6e-3 + 1e-9 : 2.5e-3);
    }
  }
}

TEST(MeshAssets, AnUnknownNameIsRefusedWithTheKnownOnes) {
  try {
    MakeMeshAsset("spleen");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("liver_1332"), std::string::npos);
  }
}

}  // namespace
}  // namespace hpdm
