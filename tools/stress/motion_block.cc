#include "tools/stress/motion_block.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "engine/baselines/surface_error.h"
#include "engine/reference_fem/tetra_fem.h"
#include "engine/reference_fem/tetra_mesh.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

const Vector3d kLow(-0.05, -0.05, -kBlockThickness);
const Vector3d kHigh(0.05, 0.05, 0);
constexpr double kBallRadius = 0.02;  // m

// Returns the triangles of the tetrahedra's faces that belong to one tetrahedron only.
SurfaceMesh SurfaceOf(const TetraMesh& mesh) {
  std::map<std::array<int, 3>, std::array<int, 3>> faces;  // sorted corners: outwards
  for (Eigen::Index e = 0; e < mesh.elements.rows(); ++e) {
    const auto node = [&](int k) { return mesh.elements(e, k); };
    for (const std::array<int, 3>& face :
         {std::array{node(0), node(2), node(1)}, std::array{node(0), node(1), node(3)},
          std::array{node(1), node(2), node(3)}, std::array{node(0), node(3), node(2)}}) {
      std::array<int, 3> key = face;
      std::sort(key.begin(), key.end());
      if (!faces.try_emplace(key, face).second) faces.erase(key);
    }
  }
  SurfaceMesh surface;
  std::map<int, int> vertices;
  surface.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
  Eigen::Index next = 0;
  for (const auto& [key, face] : faces) {
    for (int k = 0; k < 3; ++k) {
      surface.triangles(next, k) =
          vertices.try_emplace(face[k], static_cast<int>(vertices.size())).first->second;
    }
    ++next;
  }
  surface.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (const auto& [node, vertex] : vertices) surface.vertices.row(vertex) = mesh.nodes.row(node);
  return surface;
}

// Returns the rows that the others do not nearly determine: few nodes lie under many points.
std::vector<std::size_t> Independent(const std::vector<TetraRow>& rows) {
  constexpr double kApart = 0.2;
  std::map<int, Eigen::Index> columns;
  for (const TetraRow& row : rows) {
    for (const auto& [node, weight] : row) columns.try_emplace(node, std::ssize(columns));
  }
  Eigen::MatrixXd kept(std::ssize(columns), 0);  // orthonormal
  std::vector<std::size_t> independent;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(kept.rows());
    for (const auto& [node, weight] : rows[i]) v[columns.at(node)] += weight;
    const double size = v.norm();
    v -= kept * (kept.transpose() * v).eval();
    if (v.norm() < kApart * size) continue;
    kept.conservativeResize(Eigen::NoChange, kept.cols() + 1);
    kept.col(kept.cols() - 1) = v.normalized();
    independent.push_back(i);
  }
  return independent;
}

}  // namespace

OrganOptions BlockOrgan(StressModel model, bool quick) {
  OrganOptions options;
  options.name = "block";
  const int cells = quick ? 3 : 4;
  options.lattice.cells = {cells, cells, cells};
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  Choose(model, &options);
  return options;
}

SurfaceMesh BlockSurface(bool quick) {
  return SurfaceOf(quick ? BoxTetraMesh(kLow, kHigh, {14, 14, 14})
                         : BoxTetraMesh(kLow, kHigh, {20, 20, 20}));
}

std::vector<StressModel> BlockModels() {
  std::vector<StressModel> models = LatticeModels();
  models.push_back(StressModel::kContinuum);
  models.push_back(StressModel::kMassSpring);
  return models;
}

std::vector<StressModel> LatticeModels() {
  return {StressModel::kStrainSmall, StressModel::kStrainFinite, StressModel::kMetricSmall,
          StressModel::kMetricFinite};
}

StressPose AtBlock(double x, double z, double jaw, double roll) {
  return {.p_tip_W = Vector3d(x, 0, z), .roll = roll, .jaw = jaw};
}

StressTool BlockHand(std::vector<std::pair<double, StressPose>> waypoints, double x_trocar) {
  StressTool tool;
  tool.motion = Through(std::move(waypoints));
  tool.p_trocar_W = Vector3d(x_trocar, 0.01, 0.35);
  tool.tool.geometries[0].can_grasp = true;
  return tool;
}

StressTool BlockGrasp(double x, const StressPose& far, double seconds, double released,
                      double x_trocar) {
  const double z = kDefaultToolRadius;
  return BlockHand({{0, AtBlock(x, z)},
                    {kBlockStart - 0.15, AtBlock(x, z)},
                    {kBlockStart - 0.1, AtBlock(x, z, 0)},
                    {kBlockStart, AtBlock(x, z, 0)},
                    {kBlockStart + seconds, far},
                    {released, far},
                    {released, AtBlock(x, z + 0.15)}},
                   x_trocar);
}

StressTool BlockBall(double depth, double seconds, double released) {
  const StressPose away = AtBlock(0, kBallRadius + 0.01), deep = AtBlock(0, kBallRadius - depth);
  StressTool tool = BlockHand({{0, away},
                               {kBlockStart, away},
                               {kBlockStart + seconds, deep},
                               {released, deep},
                               {released, away}});
  tool.tool.geometries[0].tip_radius = kBallRadius;
  return tool;
}

const char* const kVolumeTruth =
    "volume at rest: deviation while held; degraded from 10 %, if inverted or left behind; "
    "failed from 50 %, or if 0.1 mm stay a second after release";

Points HeldBlock(const OrganOptions& organ, bool quick, const Points& held, const Points& ways) {
  const SurfaceMesh rest = BlockSurface(quick);
  const TetraBody body(Quadratic(BoxTetraMesh(kLow, kHigh, {7, 7, 7})), organ.material,
                       TetraLaw::kSmallStrain);
  TetraProblem problem = MakeTetraProblem(body, rest, organ.supports, {});
  const std::vector<TetraRow> rows = PointRows(body.mesh(), held);
  for (const std::size_t i : Independent(rows)) {
    problem.loads.push_back(
        {.patch = rows[i], .force = {}, .displacement = ways.row(static_cast<Eigen::Index>(i))});
  }
  return ApplyRows(PointRows(body.mesh(), rest.vertices), SolveTetra(body, problem).u);
}

Points Displacements(const StressSessionFixture& body) {
  return body.state().vertices - body.organ().rest().vertices;
}

StressTrial JudgeMotion(StressSessionFixture* body, double released) {
  body->RunUntil(released);
  StressTrial trial =
      Judge(std::abs(RelativeVolumeChange(body->organ().rest(), Displacements(*body))),
            kVolumeDegraded, kVolumeFailed);
  AddReturn(body, released, &trial);
  return trial;
}

void AddReturn(StressSessionFixture* body, double released, StressTrial* trial) {
  body->RunUntil(released + 1);
  const StressOutcome& outcome = body->outcome();
  AddFaults(outcome, released, trial);
  if (!outcome.finite) {
    trial->fate = StressFate::kFailed;
    trial->how = "not finite";
  } else if (outcome.displacement > StressSessionFixture::kAtRest) {
    trial->fate = StressFate::kFailed;
    trial->how = Format("%.2g mm stay", 1e3 * outcome.displacement);
  } else if (outcome.inverted_share > 0) {
    trial->fate = std::max(trial->fate, StressFate::kDegraded);
    trial->how = Format("%.2g %% inverted", 100 * outcome.inverted_share);
  } else if ((outcome.flags & kStepRecovering) != 0) {
    trial->fate = std::max(trial->fate, StressFate::kDegraded);
    trial->how = "left behind";
  }
}

}  // namespace hpdm
