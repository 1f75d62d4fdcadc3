#include "engine/solver/refinement_basis.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "engine/base/error.h"
#include "engine/energy/mixed_dilatation.h"
#include "engine/organ.h"
#include "engine/solver/compliance_solver.h"
#include "engine/tissue/interior.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr int kRefinement = 2;

// An ellipsoid in a lattice of 3 x 3 x 3 cells, held by springs everywhere (so that no region
// excludes functions).
struct LatticeBody {
  explicit LatticeBody(double poisson)
      : material{.young = 5000, .poisson = poisson},
        mesh(Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2)),
        lattice(BoundingLatticeBox(mesh.vertices, Matrix3d::Identity(), 0.01), Options()) {
    const TissueQuadrature sampled =
        SampleTissue(mesh, lattice.box(), {6, 6, 6}, {.resolution = 48});
    tissue = {sampled.points, sampled.weights};
    lattice.DropControlPointsWithoutTissue(tissue);
    K = StrainStiffness(lattice, tissue, material, Dilatation::kProjected);
    const WeightMatrix weights = lattice.Weights(tissue.points);
    springs = 1e6 * weights.transpose() * tissue.weights.asDiagonal() * weights;
    AddAlongEachAxis(springs, &K);
  }

  static LatticeOptions Options() {
    LatticeOptions options;
    options.cells = {3, 3, 3};
    return options;
  }

  RefinementBasis Local() const {
    return RefinementBasis(lattice, {.functions = 20, .refinement = kRefinement}, tissue, material,
                           Dilatation::kProjected, {}, K);
  }

  MaterialOptions material;
  SurfaceMesh mesh;
  Lattice lattice;
  Quadrature tissue;
  ScalarStiffness springs;
  FullStiffness K;
};

// The energy that refinement_basis.h describes, from the displacement gradients at the tissue's
// points: of U and V together, with what the projection does not see of V's own dilatation.
double EnergyAtPoints(const LatticeBody& body, const Lattice& finer, const Points& U,
                      const Points& V) {
  const auto [mu, lambda] = ToLame(body.material);
  const auto [pointwise, projected] = ShareLambda({mu, lambda}, Dilatation::kProjected);
  const auto coarse = body.lattice.GradientWeights(body.tissue.points),
             fine = finer.GradientWeights(body.tissue.points);
  Eigen::VectorXd own = Eigen::VectorXd::Zero(body.tissue.weights.size()), sum = own;
  double energy = 0;
  for (Eigen::Index q = 0; q < own.size(); ++q) {
    Matrix3d grad_u = Matrix3d::Zero(), grad_v = Matrix3d::Zero();
    for (int d = 0; d < 3; ++d) {
      grad_u.col(d) = (coarse[d].row(q) * U).transpose();
      grad_v.col(d) = (fine[d].row(q) * V).transpose();
    }
    const Matrix3d strain = 0.5 * (grad_u + grad_v + (grad_u + grad_v).transpose());
    own[q] = grad_v.trace();
    sum[q] = strain.trace();
    energy +=
        body.tissue.weights[q] * (mu * strain.squaredNorm() + pointwise / 2 * sum[q] * sum[q] +
                                  projected / 2 * own[q] * own[q]);
  }
  const CoarserSplines splines(body.lattice, body.tissue);
  const auto seen = [&](const Eigen::VectorXd& field) {
    return splines.Project(WeightMatrix(field.sparseView())).squaredNorm();
  };
  energy += projected / 2 * (seen(sum) - seen(own));
  for (int d = 0; d < 3; ++d) energy += 0.5 * U.col(d).dot(body.springs * U.col(d));
  return energy;
}

class RefinementBasisTest : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(PoissonRatios, RefinementBasisTest, testing::Values(0.3, 0.45));

TEST_P(RefinementBasisTest, CouplingAndReducedStiffnessHoldTheEnergy) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  std::srand(1);
  const Points U = 1e-3 * Points::Random(body.lattice.size(), 3);
  Points V = Points::Zero(local.size(), 3);
  const std::vector<int> used = {3, 40, 41, local.size() / 2, local.size() - 5};
  for (const int a : used) V.row(a) = 1e-3 * Eigen::RowVector3d::Random();

  // 1/2 |U + Y V|_K^2 + 1/2 V^T Sigma V.
  Eigen::VectorXd moved = Eigen::Map<const Eigen::VectorXd>(U.data(), U.size());
  double energy = 0;
  for (const int a : used) {
    moved += local.Coupling(a) * V.row(a).transpose();
    for (const int b : used) {
      energy += 0.5 * V.row(a) * local.ReducedStiffness(a, b) * V.row(b).transpose();
    }
  }
  energy += 0.5 * moved.dot(body.K * moved);
  const double exact = EnergyAtPoints(body, local.finer(), U, V);
  // Round-off times the condition of K, and the damping of nearly dependent coarser splines.
  EXPECT_NEAR(energy, exact, 1e-7 * exact);
}

TEST_P(RefinementBasisTest, NoneTouchesASupportsRegion) {
  const LatticeBody body(GetParam());
  Quadrature region{body.tissue.points.topRows(200), body.tissue.weights.head(200)};
  const RefinementBasis local(body.lattice, {.functions = 20, .refinement = kRefinement},
                              body.tissue, body.material, Dilatation::kProjected, {region}, body.K);
  EXPECT_LT(local.size(), body.Local().size());
  EXPECT_EQ(local.finer().Weights(region.points).nonZeros(), 0);
}

// A press on top of the body, its row over the lattice and the local functions in use.
class RefinedPress {
 public:
  RefinedPress(const LatticeBody& body, const RefinementBasis& local)
      : body_(body), local_(local), contacts_(body.lattice.size(), local.size(), 20) {}

  // Compliance under the press at p.
  double Compliance(ComplianceSolver* solver, const Vector3d& p) {
    contacts_.Clear();
    const Vector3d points[] = {p};
    contacts_.refinement.ChooseNearest(local_.centres(), points, 20);
    ContactConstraints::Row* row = contacts_.Add();
    row->p_rest_W = p;
    auto weights = contacts_.WeightRow(0);
    body_.lattice.ForEachFunction(p, [&](int column, double value) { weights[column] = value; });
    local_.finer().ForEachFunction(p, [&](int function, double value) {
      const int slot = contacts_.refinement.Slot(function);
      if (slot >= 0) weights[body_.lattice.size() + slot] = value;
    });
    contact_solver_.Build(contacts_);
    solver->Respond(contacts_, &contact_solver_);
    return contact_solver_.compliance()(0, 0);
  }
  const ActiveRefinement& active() const { return contacts_.refinement; }

 private:
  const LatticeBody& body_;
  const RefinementBasis& local_;
  ContactConstraints contacts_;
  ContactSolver contact_solver_;
};

TEST_P(RefinementBasisTest, AMovedSetEqualsANewOne) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  RefinedPress press(body, local);
  const auto moving = MakeComplianceSolver(local, 20), fresh = MakeComplianceSolver(local, 20);
  double last = 0;
  for (int i = 0; i <= 10; ++i) {
    last = press.Compliance(moving.get(), Vector3d(0.008 * i - 0.04, 0.01, 0.045));
  }
  RefinedPress again(body, local);
  const double first = again.Compliance(fresh.get(), Vector3d(0.04, 0.01, 0.045));
  EXPECT_NEAR(last, first, 1e-9 * first);  // the order of the slots only
}

TEST_P(RefinementBasisTest, FunctionsEnterAndLeaveWithoutAJump) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  RefinedPress press(body, local);
  const auto solver = MakeComplianceSolver(local, 20);
  const auto compliance = [&](double x) {
    return press.Compliance(solver.get(), Vector3d(x, 0.011, 0.045));
  };
  const auto set_at = [&](double x) {
    compliance(x);
    std::set<int> functions;
    for (int s = 0; s < 20; ++s) functions.insert(press.active().Function(s));
    return functions;
  };
  int swaps = 0;
  for (int i = 0; i < 30; ++i) {
    double before = 5e-4 * i, behind = before + 5e-4;
    const std::set<int> first = set_at(before);
    if (set_at(behind) == first) continue;
    ++swaps;
    while (behind - before > 1e-9) {
      const double middle = (before + behind) / 2;
      (set_at(middle) == first ? before : behind) = middle;
    }
    // A nanometre: the weights there are below 1e-6. At full weight a function makes some 1e-3.
    EXPECT_NEAR(compliance(behind) / compliance(before), 1, 1e-6) << before;
  }
  EXPECT_GT(swaps, 3);
}

TEST_P(RefinementBasisTest, FunctionsSoftenAPressAndNeverStiffenIt) {
  const LatticeBody body(GetParam());
  const RefinementBasis local = body.Local();
  const auto plain = MakeComplianceSolver(body.K), refined = MakeComplianceSolver(local, 20);
  for (const double x : {-0.06, -0.02, 0.0, 0.03}) {
    const Vector3d p(x, 0.01, 0.04);
    ContactConstraints contacts(body.lattice.size());
    contacts.Add();
    auto weights = contacts.WeightRow(0);
    body.lattice.ForEachFunction(p, [&](int column, double value) { weights[column] = value; });
    ContactSolver contact_solver;
    contact_solver.Build(contacts);
    plain->Respond(contacts, &contact_solver);
    // A larger space has a smaller least energy; a point load gains well over a tenth.
    EXPECT_GT(RefinedPress(body, local).Compliance(refined.get(), p),
              1.1 * contact_solver.compliance()(0, 0));
  }
}

TEST(LocalFunctionsOfAnOrgan, AreTwentySevenUnlessGivenWhereTheModelTakesThem) {
  OrganOptions organ;
  EXPECT_EQ(organ.energy.type, EnergyType::kStrain);
  EXPECT_EQ(LocalFunctionsOf(organ), 27);
  for (const StrainMeasure strain : {StrainMeasure::kFinite, StrainMeasure::kAdaptive}) {
    organ.energy.strain = strain;
    EXPECT_EQ(LocalFunctionsOf(organ), 27);
  }
  for (const int given : {0, 5}) {
    organ.lattice.local.functions = given;
    EXPECT_EQ(LocalFunctionsOf(organ), given);
  }
  std::vector<OrganOptions> without(7);
  without[0].energy.type = EnergyType::kMetric;
  without[1].energy.solver = SolverType::kGaussSeidel;
  without[2].lattice.basis = BasisType::kBernstein;
  without[3].model = OrganModelType::kContinuum;
  without[4].model = OrganModelType::kMassSpring;
  without[5].model = OrganModelType::kRigid;
  without[6].lattice.cells = {51, 50, 50};  // of half the size, more than a million
  for (std::size_t i = 0; i < without.size(); ++i) EXPECT_EQ(LocalFunctionsOf(without[i]), 0) << i;
}

TEST(LocalFunctionsOfAnOrgan, AreRefusedWhereTheModelCannotHaveThemButTheyAreGiven) {
  const SurfaceMesh rest = Ellipsoid(Vector3d(0.1, 0.07, 0.05), 2);
  OrganOptions organ;
  organ.name = "ellipsoid";
  organ.lattice.cells = {2, 2, 2};
  organ.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  const OrganModel refined(organ, rest);
  EXPECT_NE(refined.refinement_basis(), nullptr);
  EXPECT_EQ(refined.RefinementSlots(2), 54);
  organ.energy.type = EnergyType::kMetric;
  EXPECT_EQ(OrganModel(organ, rest).RefinementSlots(2), 0);
  organ.lattice.local.functions = 5;
  EXPECT_THROW(OrganModel(organ, rest), InputError);
}

TEST(ActiveRefinement, TakesTheNearestAndKeepsTheirSlots) {
  Points centres(100, 3);
  for (int a = 0; a < 100; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(100, 4);
  const Vector3d first[] = {Vector3d(10.4, 0, 0)};
  active.ChooseNearest(centres, first, 4);
  std::array<int, 4> slot{};
  for (int a = 9; a <= 12; ++a) {
    ASSERT_GE(active.Slot(a), 0) << a;
    EXPECT_EQ(active.Function(active.Slot(a)), a);
    EXPECT_TRUE(active.Changed(active.Slot(a)));
    slot[a - 9] = active.Slot(a);
  }
  const Vector3d moved[] = {Vector3d(11.4, 0, 0)};
  active.ChooseNearest(centres, moved, 4);
  EXPECT_EQ(active.Slot(9), -1);
  for (int a = 10; a <= 12; ++a) {
    EXPECT_EQ(active.Slot(a), slot[a - 9]);
    EXPECT_FALSE(active.Changed(active.Slot(a)));
  }
  EXPECT_EQ(active.Slot(13), slot[0]);
  EXPECT_TRUE(active.Changed(slot[0]));
}

TEST(ActiveRefinement, TheFarthestFunctionsFadeWithDistance) {
  Points centres(100, 3);
  for (int a = 0; a < 100; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(100, 4);
  const auto follow = [&](double x, double share = 1) {
    const Vector3d point[] = {Vector3d(x, 0, 0)};
    active.ChooseNearest(centres, point, 4, share);
  };
  const auto weight = [&](int function) { return active.Weight(active.Slot(function)); };
  follow(10.49);  // 9 .. 12 are in; 12 is at 1.51, 8, the first outside, at 2.49
  EXPECT_EQ(weight(10), 1);
  EXPECT_EQ(weight(12), 1);
  follow(10.99);  // 13 comes at 11.0: 9 is at 1.99, 13 at 2.01
  EXPECT_NEAR(weight(9), (1 - 1.99 * 1.99 / (2.01 * 2.01)) / ActiveRefinement::kBand, 1e-12);
  EXPECT_NEAR(active.Kept(active.Slot(9)), weight(9), 1e-12);
  EXPECT_EQ(active.Kept(active.Slot(10)), 1);
  const double fading = weight(9);
  follow(10.99, 0.5);
  EXPECT_EQ(weight(10), 0.5);
  EXPECT_NEAR(weight(9), fading / 2, 1e-12);  // round-off
  EXPECT_EQ(active.Kept(active.Slot(10)), 0.5);
  follow(11.0 + 1e-9);
  EXPECT_EQ(weight(13), ActiveRefinement::kMinWeight);
  follow(11.0, 0);
  EXPECT_EQ(active.used(), 0);
}

TEST(ActiveRefinement, WithoutContactAllAreReleased) {
  ActiveRefinement active(10, 4);
  const Vector3d point[] = {Vector3d::Zero()};
  const Points centres = Points::Random(10, 3);
  active.ChooseNearest(centres, point, 4);
  active.ChooseNearest(centres, {}, 4);
  for (int s = 0; s < 4; ++s) EXPECT_EQ(active.Function(s), -1);
}

TEST(ActiveRefinement, TwoContactsShareTheSlots) {
  Points centres(10, 3);
  for (int a = 0; a < 10; ++a) centres.row(a) = Eigen::RowVector3d(a, 0, 0);
  ActiveRefinement active(10, 8);
  const Vector3d points[] = {Vector3d(1.4, 0, 0), Vector3d(3.4, 0, 0)};
  active.ChooseNearest(centres, points, 4);  // 0..3 and 2..5: two are in both
  int used = 0;
  for (int s = 0; s < 8; ++s) used += active.Function(s) >= 0;
  EXPECT_EQ(used, 6);
}

}  // namespace
}  // namespace hpdm
