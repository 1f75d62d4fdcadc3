// An organ lifted off another that it hangs on, against quadratic tetrahedra that fill both organs and
// the layer between them.

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "engine/baselines/surface_error.h"
#include "engine/reference_fem/tetra_fem.h"
#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"
#include "tools/shared/organ_bench.h"

namespace hpdm {
namespace {

constexpr double kPoisson = 0.3;
constexpr double kSlabYoung = 5000, kBlockYoung = 20000;              // Pa
constexpr double kGap = 0.001;                                        // m, thickness of the layer
const Vector3d kSlab(0.06, 0.048, 0.02), kBlock(0.04, 0.024, 0.016);  // m
constexpr double kMotionHalf = 1;                                     // s, of a period

// A slab below z = 0, a smaller block above it, and a layer of kGap between them.
struct LiftedPair {
  double layer_young;  // Pa
  Vector3d lift_W;     // m, of the block's top

  AttachmentOptions Layer() const {
    AttachmentOptions layer =
        BedLayer("block", "slab", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 1.5 * kGap);
    layer.young = layer_young;
    layer.thickness = kGap;
    layer.strength = 1e6;  // does not tear
    layer.toughness = 2 * LeastToughness(layer, layer.thickness);
    return layer;
  }
  static SupportOptions Bottom() {
    return {hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.8 * kSlab.z())}, {}};
  }
  static SupportOptions Top() {
    return {hpdm::Box{Vector3d(-1, -1, kGap + 0.75 * kBlock.z()), Vector3d(1, 1, 1)}, {}};
  }
  static SurfaceMesh SlabSurface() {
    return GridBox(Vector3d(-kSlab.x() / 2, -kSlab.y() / 2, -kSlab.z()),
                   Vector3d(kSlab.x() / 2, kSlab.y() / 2, 0), {24, 20, 8});
  }
  static SurfaceMesh BlockSurface() {
    return GridBox(Vector3d(-kBlock.x() / 2, -kBlock.y() / 2, kGap),
                   Vector3d(kBlock.x() / 2, kBlock.y() / 2, kGap + kBlock.z()), {16, 10, 6});
  }
};

struct PairDisplacements {
  Points slab, block;  // of the surfaces' vertices, m
};

OrganOptions Part(const std::string& name, double young, const std::array<int, 3>& cells,
                  const SupportOptions& support) {
  OrganOptions options;
  options.name = name;
  options.material = {.young = young, .poisson = kPoisson};
  options.lattice.cells = cells;
  options.lattice.margin = 0.0005;
  options.lattice.local.functions = 0;
  options.supports.push_back(support);
  return options;
}

PairDisplacements OnLattices(const LiftedPair& pair, int fineness) {
  OrganBench bench;
  bench.Add(Part("slab", kSlabYoung, {3 * fineness, 2 * fineness, fineness + 1}, pair.Bottom()),
            pair.SlabSurface());
  OrganOptions block =
      Part("block", kBlockYoung, {2 * fineness, fineness + 1, fineness}, pair.Top());
  block.motion = {pair.lift_W, 0.5 / kMotionHalf};
  bench.Add(block, pair.BlockSurface());
  bench.Attach(pair.Layer());
  bench.Start();
  for (int step = 0; step <= 30; ++step) {
    bench.StayAt(step * kMotionHalf / 30);
    bench.Step();
  }
  EXPECT_EQ(bench.loop().links()[0].outcomes()[0].freed_area, 0);
  return {bench.Drawn(0).vertices - bench.model(0).rest().vertices,
          bench.Drawn(1).vertices - bench.model(1).rest().vertices};
}

Points Stacked(const Points& a, const Points& b) {
  Points both(a.rows() + b.rows(), 3);
  both << a, b;
  return both;
}

// Bricks of about `edge`, with the layer one brick thick.
TetraMesh LayeredMesh(double edge) {
  const auto count = [&](double length) { return static_cast<int>(std::lround(length / edge)); };
  const int below = count(kSlab.z()), above = count(kBlock.z());
  TetraMesh mesh = BoxTetraMesh(Vector3d(-kSlab.x() / 2, -kSlab.y() / 2, -below),
                                Vector3d(kSlab.x() / 2, kSlab.y() / 2, 1 + above),
                                {count(kSlab.x()), count(kSlab.y()), below + 1 + above});
  const auto height = [&](double z) {
    if (z <= 0) return z * kSlab.z() / below;
    return z <= 1 ? z * kGap : kGap + (z - 1) * kBlock.z() / above;
  };
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n) {
    mesh.nodes(n, 2) = height(std::round(mesh.nodes(n, 2)));
  }
  std::map<int, int> number;
  std::vector<std::array<int, 4>> kept;
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    Vector3d middle = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) middle += mesh.nodes.row(mesh.elements(e, k)).transpose() / 4;
    const bool over_slab_only =
        std::abs(middle.x()) > kBlock.x() / 2 || std::abs(middle.y()) > kBlock.y() / 2;
    if (middle.z() > 0 && over_slab_only) continue;
    kept.emplace_back();
    for (int k = 0; k < 4; ++k) {
      const int node = mesh.elements(e, k);
      kept.back()[static_cast<std::size_t>(k)] =
          number.try_emplace(node, static_cast<int>(number.size())).first->second;
    }
  }
  Points nodes(static_cast<Eigen::Index>(number.size()), 3);
  for (const auto& [from, to] : number) nodes.row(to) = mesh.nodes.row(from);
  Tetrahedra elements(static_cast<Eigen::Index>(kept.size()), 4);
  for (std::size_t e = 0; e < kept.size(); ++e) {
    for (int k = 0; k < 4; ++k) {
      elements(static_cast<Eigen::Index>(e), k) = kept[e][static_cast<std::size_t>(k)];
    }
  }
  return Quadratic(MakeTetraMesh(nodes, elements, "layered mesh"));
}

// The meshed layer has the normal stiffness of the attachment's law.
PairDisplacements OnTetrahedra(const LiftedPair& pair, double edge) {
  const TetraMesh mesh = LayeredMesh(edge);
  const double confined = (1 - kPoisson) / ((1 + kPoisson) * (1 - 2 * kPoisson));
  Eigen::VectorXd stiffness(mesh.elements.rows());
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    double z = 0;
    for (int k = 0; k < 4; ++k) z += mesh.nodes(mesh.elements(e, k), 2) / 4;
    stiffness[e] = z < 0      ? 1
                   : z < kGap ? pair.layer_young / confined / kSlabYoung
                              : kBlockYoung / kSlabYoung;
  }
  const TetraBody body(mesh, {.young = kSlabYoung, .poisson = kPoisson}, TetraLaw::kSmallStrain,
                       stiffness);
  TetraProblem problem = MakeTetraProblem(body, pair.SlabSurface(), {pair.Bottom()}, {});
  const TetraProblem top = MakeTetraProblem(body, pair.SlabSurface(), {pair.Top()}, {});
  problem.springs.Add(top.springs);
  top.springs.Multiply(pair.lift_W.transpose().replicate(mesh.nodes.rows(), 1), &problem.forces);
  const TetraSolution solution = SolveTetra(body, problem);
  EXPECT_TRUE(solution.converged);
  return {ApplyRows(PointRows(mesh, pair.SlabSurface().vertices), solution.u),
          ApplyRows(PointRows(mesh, pair.BlockSurface().vertices), solution.u)};
}

// The relative error over both surfaces together.
double ErrorOf(const PairDisplacements& found, const PairDisplacements& exact) {
  const SurfaceMesh slab = LiftedPair::SlabSurface();
  SurfaceMesh both = slab;
  const SurfaceMesh block = LiftedPair::BlockSurface();
  both.vertices = Stacked(slab.vertices, block.vertices);
  both.triangles.resize(slab.triangles.rows() + block.triangles.rows(), 3);
  const int first = static_cast<int>(slab.vertices.rows());
  both.triangles << slab.triangles, (block.triangles.array() + first).matrix();
  return RelativeSurfaceError(both, Stacked(found.slab, found.block),
                              Stacked(exact.slab, exact.block));
}

// Lifted by 30 mm: twice the height of the block. Through the firm layer the slab is drawn up with it;
// the other is so soft that its stiffness decides. Finer lattices come nearer.
TEST(LiftedPair, MovesAsTetrahedraWithTheLayerMeshed) {
  for (const double layer_young : {20000.0, 300.0}) {
    const LiftedPair pair{layer_young, Vector3d(0, 0, 0.03)};
    const PairDisplacements exact = OnTetrahedra(pair, 0.003);
    const double coarse = ErrorOf(OnLattices(pair, 2), exact);
    const double fine = ErrorOf(OnLattices(pair, 4), exact);
    EXPECT_LT(fine, 0.06) << layer_young;
    EXPECT_LT(fine, coarse) << layer_young;
  }
}

}  // namespace
}  // namespace hpdm
