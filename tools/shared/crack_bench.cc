#include "tools/shared/crack_bench.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

#include "engine/base/error.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kPull = 100;      // Pa
constexpr double kBeyond = 0.01;   // m: a strip's reach beyond the surface
constexpr double kBesides = 1e-7;  // m: from a crack's surface to a point on one side
constexpr std::array<int, 3> kSquares = {4, 4, 4};

OrientedBox LatticeBox(const SurfaceMesh& mesh, const CrackModelOptions& options,
                       std::array<int, 3>* cells) {
  OrientedBox box = BoundingLatticeBox(mesh.vertices, options.axes, 0);
  box.origin_W -= options.axes * (options.cell * options.offset);
  for (int d = 0; d < 3; ++d) {
    const double length = box.lengths[d] + options.cell * options.offset[d];
    (*cells)[static_cast<std::size_t>(d)] =
        static_cast<int>(std::ceil(length / options.cell - 1e-9));
    box.lengths[d] = (*cells)[static_cast<std::size_t>(d)] * options.cell;
  }
  return box;
}

Lattice MakeLattice(const SurfaceMesh& mesh, const CrackModelOptions& options) {
  LatticeOptions lattice;
  const OrientedBox box = LatticeBox(mesh, options, &lattice.cells);
  return {box, lattice};
}

// Returns E' = E / (1 - nu^2) of plane strain, Pa.
double PlaneModulus(double poisson) { return CrackModel::kYoung / (1 - poisson * poisson); }

void Turn(const Matrix3d& R, SurfaceMesh* mesh) { mesh->vertices = mesh->vertices * R.transpose(); }
void Turn(const Matrix3d& R, std::vector<FacePoint>* face) {
  for (FacePoint& point : *face) point.p = R * point.p;
}

}  // namespace

std::vector<FacePoint> FaceOf(const Vector3d& low, const Vector3d& high, int axis, bool upper,
                              double spacing) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const Vector3d size = high - low;
  const int along_u = static_cast<int>(std::ceil(size[u] / spacing)),
            along_v = static_cast<int>(std::ceil(size[v] / spacing));
  std::vector<FacePoint> face;
  for (int i = 0; i < along_u; ++i) {
    for (int j = 0; j < along_v; ++j) {
      Vector3d p = upper ? high : low;
      p[u] = low[u] + size[u] * (i + 0.5) / along_u;
      p[v] = low[v] + size[v] * (j + 0.5) / along_v;
      face.push_back({p, size[u] * size[v] / (along_u * along_v)});
    }
  }
  return face;
}

CrackModel::CrackModel(const SurfaceMesh& mesh, const std::vector<CutOptions>& cuts,
                       const CrackModelOptions& options)
    : cell_(options.cell), lattice_(MakeLattice(mesh, options)) {
  InteriorOptions interior;
  std::array<int, 3> cells;
  for (int d = 0; d < 3; ++d) {
    interior.support_cells[static_cast<std::size_t>(d)] = lattice_.basis().axis(d).support();
    cells[static_cast<std::size_t>(d)] = lattice_.basis().axis(d).cells();
  }
  std::vector<CutSurface> surfaces;
  for (const CutOptions& cut : cuts) surfaces.emplace_back(lattice_.box(), cut, mesh);
  if (!surfaces.empty()) {
    interior.cuts = std::make_shared<const std::vector<CutSurface>>(std::move(surfaces));
  }
  tissue_ = SampleTissue(mesh, lattice_.box(), cells, interior);
  const Quadrature tissue{tissue_.points, tissue_.weights};
  if (options.splits) {
    lattice_.SplitByTissue(std::make_shared<const TissuePieces>(tissue_.pieces));
  }
  lattice_.DropControlPointsWithoutTissue(tissue);
  if (options.splits && options.fronts && interior.cuts != nullptr) lattice_.AddFrontFunctions();
  MaterialOptions material;
  material.young = kYoung;
  material.poisson = options.poisson;
  K_ = StrainStiffness(lattice_, tissue, material, Dilatation::kProjected);
  loads_.setZero(K_.rows());
}

void CrackModel::Hold(const std::vector<FacePoint>& face, const Vector3d& direction) {
  constexpr double kStiff = 1e4;
  for (const FacePoint& point : face) {
    const double spring = kStiff * kYoung / cell_ * point.area;
    lattice_.ForEachFunction(point.p, [&](int a, double phi_a) {
      lattice_.ForEachFunction(point.p, [&](int b, double phi_b) {
        K_.block<3, 3>(3 * a, 3 * b) += spring * phi_a * phi_b * direction * direction.transpose();
      });
    });
  }
}

void CrackModel::Pull(const std::vector<FacePoint>& face, const Vector3d& traction) {
  for (const FacePoint& point : face) {
    lattice_.ForEachFunction(point.p, [&](int a, double phi) {
      loads_.segment<3>(3 * a) += point.area * phi * traction;
    });
  }
}

void CrackModel::HoldWeakly() {
  const WeightMatrix weights = lattice_.Weights(tissue_.points);
  const double spring = 1e-6 * kYoung / lattice_.box().lengths.squaredNorm();
  AddAlongEachAxis(spring * weights.transpose() * tissue_.weights.asDiagonal() * weights, &K_);
}

void CrackModel::Solve() {
  const Eigen::LLT<Eigen::MatrixXd> factor(K_);
  if (factor.info() != Eigen::Success) {
    throw InputError("the stiffness of a body with a crack is not positive definite; hold it");
  }
  U_ = factor.solve(loads_);
}

Vector3d CrackModel::Displacement(const Vector3d& p, const Vector3d& side) const {
  Vector3d u = Vector3d::Zero();
  lattice_.ForEachFunction(lattice_.SiteOf(p, side),
                           [&](int a, double phi) { u += phi * U_.segment<3>(3 * a); });
  return u;
}

CrackOpening EdgeCrack(const CrackModelOptions& options, double a, double turn) {
  constexpr double kWidth = 0.04, kLength = 0.12;
  const double thickness = options.cell;
  const Vector3d low(0, -kLength / 2, 0), high(kWidth, kLength / 2, thickness);
  const Matrix3d R = Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
  SurfaceMesh mesh = GridBox(low, high, kSquares);
  Turn(R, &mesh);
  CutOptions cut;
  for (const double x : {-kBeyond, a}) {
    cut.strip.push_back({R * Vector3d(x, 0, -kBeyond), R * Vector3d(x, 0, thickness + kBeyond)});
  }
  CrackModel model(mesh, {cut}, options);
  const double spacing = options.cell / 4;
  for (const bool upper : {false, true}) {
    std::vector<FacePoint> roller = FaceOf(low, high, 2, upper, spacing),
                           end = FaceOf(low, high, 1, upper, spacing);
    Turn(R, &roller);
    Turn(R, &end);
    model.Hold(roller, Vector3d::UnitZ());
    model.Pull(end, R * Vector3d(0, upper ? kPull : -kPull, 0));
  }
  model.HoldWeakly();
  model.Solve();
  const auto lip = [&](double y) {
    const Vector3d p = R * Vector3d(0, y, thickness / 2);
    return (R.transpose() * model.Displacement(p, p)).y();
  };
  const double x = std::numbers::pi * a / (2 * kWidth);
  const double shape = (1.46 + 3.42 * (1 - std::cos(x))) / (std::cos(x) * std::cos(x));
  const double closed_form = 4 * kPull * a * shape / PlaneModulus(options.poisson);
  return {(lip(kBesides) - lip(-kBesides)) / closed_form, model.Energy(), model.lattice().size(),
          model.lattice().front_functions()};
}

double EdgeCrackRelease(const CrackModelOptions& options, double a, double da) {
  const double released =
      (EdgeCrack(options, a + da).energy - EdgeCrack(options, a).energy) / (da * options.cell);
  const double middle = a + da / 2, x = middle / 0.04;
  const double F = 1.12 - 0.231 * x + 10.55 * x * x - 21.72 * x * x * x + 30.39 * x * x * x * x;
  const double K = F * kPull * std::sqrt(std::numbers::pi * middle);
  return released / (K * K / PlaneModulus(options.poisson));
}

CrackOpening PennyCrack(const CrackModelOptions& options) {
  constexpr double kSide = 0.1, kRadius = 0.02;
  const Vector3d low = Vector3d::Constant(-kSide / 2), high = Vector3d::Constant(kSide / 2);
  constexpr int kChords = 16;
  CutOptions cut;
  for (int i = 0; i < kChords; ++i) {
    const double angle = std::numbers::pi * (i + 0.5) / kChords;
    const double x = -kRadius * std::cos(angle), z = kRadius * std::sin(angle);
    cut.strip.push_back({Vector3d(x, 0, -z), Vector3d(x, 0, z)});
  }
  CrackModel model(GridBox(low, high, kSquares), {cut}, options);
  for (const bool upper : {false, true}) {
    model.Pull(FaceOf(low, high, 1, upper, options.cell / 4),
               Vector3d(0, upper ? kPull : -kPull, 0));
  }
  model.HoldWeakly();
  model.Solve();
  const auto lip = [&](double y) {
    const Vector3d p(0.001, y, 0.001);
    return model.Displacement(p, p).y();
  };
  const double closed_form =
      8 * kPull * kRadius / (std::numbers::pi * PlaneModulus(options.poisson));
  return {(lip(kBesides) - lip(-kBesides)) / closed_form, model.Energy(), model.lattice().size(),
          model.lattice().front_functions()};
}

DoubleCantileverRatios DoubleCantilever(const CrackModelOptions& options, double a_over_h) {
  constexpr double kArm = 0.02, kLength = 16 * kArm;
  const double width = options.cell, poisson = options.poisson;
  const Vector3d low(0, -kArm, 0), high(kLength, kArm, width);
  DoubleCantileverRatios ratios;
  const auto compliance = [&](double a) {
    CutOptions cut;
    for (const double x : {-kBeyond, a}) {
      cut.strip.push_back({Vector3d(x, 0, -kBeyond), Vector3d(x, 0, width + kBeyond)});
    }
    CrackModel model(GridBox(low, high, kSquares), {cut}, options);
    const double spacing = options.cell / 4;
    for (const bool upper : {false, true}) {
      model.Hold(FaceOf(low, high, 2, upper, spacing), Vector3d::UnitZ());
      // A shear force over the arm's end.
      const Vector3d arm_low(0, upper ? 0 : -kArm, 0), arm_high(0, upper ? kArm : 0, width);
      model.Pull(FaceOf(arm_low, arm_high, 0, false, spacing),
                 Vector3d(0, upper ? kPull : -kPull, 0));
    }
    model.HoldWeakly();
    model.Solve();
    ratios.functions = model.lattice().size();
    const double P = kPull * kArm * width;
    return 2 * model.Energy() / (P * P);
  };
  const double a = a_over_h * kArm, modulus = PlaneModulus(poisson);
  const double shear = CrackModel::kYoung / (2 * (1 + poisson));
  const double closed_form =
      8 * std::pow(a + 0.67 * kArm, 3) / (modulus * width * std::pow(kArm, 3)) +
      2.4 * a / (shear * width * kArm);
  ratios.compliance = compliance(a) / closed_form;
  const double da = 0.002;
  const double P = kPull * kArm * width;
  const double released =
      P * P / (2 * width) * (compliance(a + da / 2) - compliance(a - da / 2)) / da;
  const double K = 2 * std::sqrt(3.0) * P * (a + 0.69 * kArm) / (width * std::pow(kArm, 1.5));
  ratios.release = released / (K * K / modulus);
  return ratios;
}

}  // namespace hpdm
