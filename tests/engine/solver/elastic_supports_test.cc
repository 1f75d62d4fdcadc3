// Viscoelastic tissue on supports that do not relax.

#include "engine/solver/elastic_supports.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "engine/solver/maxwell_memory.h"
#include "tests/support/relaxation_fixture.h"

namespace hpdm {
namespace {

constexpr PronySeries kOneTerm{.count = 1, .terms = {{{0.6, 0.5}}}};
constexpr PronySeries kTwoTerms{.count = 2, .terms = {{{0.4, 0.05}, {0.3, 2}}}};

// A bar of stiffness `tissue` whose end 1 stands on a spring `support` (N/m), held at end 0.
class Bar {
 public:
  Bar(double tissue, double support, const PronySeries& prony) : springs_(2, 2) {
    springs_.insert(1, 1) = support;
    Eigen::Matrix2d K;
    K << tissue, -tissue, -tissue, tissue + support;
    FullStiffness full = FullStiffness::Zero(6, 6);
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) full.block<3, 3>(3 * a, 3 * b) = K(a, b) * Matrix3d::Identity();
    }
    relaxation_ = MakeCholeskyRelaxation(full);
    supports_ = std::make_shared<ElasticSupports>(*relaxation_->compliance(), springs_, 2);
    memory_ = std::make_unique<MaxwellMemory>(prony, 2, supports_);
  }
  // Returns the force that holds end 0 at `moved` (m) after a step of `dt` (s).
  double Hold(double moved, double dt) {
    contacts_.Clear();
    ContactConstraints::Row* row = contacts_.Add();
    row->kind = kGrasp;
    row->target_W = Vector3d(0, 0, moved);
    contacts_.WeightRow(0)[0] = 1;
    memory_->Relax(dt, relaxation_.get(), &contacts_, &U_);
    return contacts_[0].force_W.z();
  }
  const ElasticSupports& supports() const { return *supports_; }

 private:
  ScalarStiffness springs_;
  std::unique_ptr<Relaxation> relaxation_;
  std::shared_ptr<ElasticSupports> supports_;
  std::unique_ptr<MaxwellMemory> memory_;
  ContactConstraints contacts_{2};
  Points U_ = Points::Zero(2, 3);
};

// Two springs in series of which one relaxes: the force falls from F_0 to F_inf, more slowly than
// the tissue's own time because the support moves after it.
TEST(ElasticSupports, AMaxwellBarOnASpringRelaxesByItsClosedForm) {
  constexpr double kTissue = 200, kMoved = 0.01;
  const double share = kOneTerm.terms[0].share, r = share / (1 - share);
  for (const double support : {20.0, 200.0, 5000.0}) {
    Bar bar(kTissue, support, kOneTerm);
    const double C_0 = 1 / support, C = C_0 + 1 / kTissue;
    const double tau = kOneTerm.terms[0].time * (1 + r * C_0 / C);
    const double F_0 = kMoved / (C_0 + 1 / (kTissue * (1 + r))), F_inf = kMoved / C;
    constexpr double kStep = 0.002;
    for (int i = 0; i < 1500; ++i) {
      const double force = bar.Hold(kMoved, kStep);
      // The ramp of the first step began half a step earlier; U is linear in each step, which errs
      // by (dt / tau)^2.
      const double law = F_inf + (F_0 - F_inf) * std::exp(-(i + 0.5) * kStep / tau);
      ASSERT_NEAR(force, law, 1e-4 * law) << support << ' ' << i;
    }
  }
}

TEST(ElasticSupports, ABarOnASoftSpringIsAsStiffAtOnceAsTheSpring) {
  Bar bar(1e6, 1, kOneTerm);
  EXPECT_NEAR(bar.Hold(0.01, 1e-4), 0.01, 1e-7);
}

// The lattice of a block on springs in its lower fifth.
class SupportedBlockTest : public ContactBlockTest {
 protected:
  static ScalarStiffness Springs(const Lattice& lattice, double stiffness) {
    OrientedBox bottom = Block();
    bottom.lengths.z() *= 0.2;
    SupportOptions support;
    support.stiffness = stiffness;
    const Quadrature region = BoxQuadrature(bottom, {12, 12, 6});
    return SupportStiffness(lattice, region, {support}, {region}, 1);
  }
  void Build(double stiffness) {
    springs_ = Springs(lattice_, stiffness);
    tissue_K_ =
        StrainStiffness(lattice_, BoxQuadrature(Block(), {12, 12, 12}), {}, Dilatation::kProjected);
    K_ = tissue_K_;
    AddAlongEachAxis(springs_, &K_);
    relaxation_ = MakeCholeskyRelaxation(K_);
    supports_ =
        std::make_shared<ElasticSupports>(*relaxation_->compliance(), springs_, lattice_.size());
  }
  Eigen::VectorXd AsVector(const Points& U) const {
    return Eigen::Map<const Eigen::VectorXd>(U.data(), U.size());
  }

  ScalarStiffness springs_;
  FullStiffness tissue_K_, K_;
  std::unique_ptr<Relaxation> relaxation_;
  std::shared_ptr<ElasticSupports> supports_;
};

// The branches are integrated here apart, with K_t itself.
TEST_F(SupportedBlockTest, EveryStepEndsInEquilibriumWithTheBranchesOfTheTissueAlone) {
  for (const double stiffness : {1e4, 1e6, 1e9}) {
    Build(stiffness);
    MaxwellMemory memory(kTwoTerms, lattice_.size(), supports_);
    U_.setZero();
    Points last = U_;
    std::array<Points, 2> W{U_, U_};
    int i = 0;
    for (const double dt : {0.033, 0.002, 0.4, 0.033, 0.1, 5.0}) {
      contacts_.Clear();
      ++i;
      AddContact(kGrasp, {0.12, 0.08, 0.1}, Vector3d(0.001 * i, 0, 0.004 * (i % 3)));
      AddContact(kPress, {0.03, 0.05, 0.1}, Vector3d(0, 0, -0.002 * (i % 2)));
      memory.Relax(dt, relaxation_.get(), &contacts_, &U_);
      const MaxwellStep step(kTwoTerms, dt);
      Eigen::VectorXd load = -K_ * AsVector(U_);
      for (std::size_t k = 0; k < 2; ++k) {
        W[k] = step.decay[k] * W[k] + step.gain[k] * (U_ - last);
        load -= step.ratio[k] * tissue_K_ * AsVector(W[k]);
      }
      Points of_rows = Points::Zero(lattice_.size(), 3);
      for (int c = 0; c < contacts_.size(); ++c) {
        of_rows += contacts_.Weights().row(c).transpose() * contacts_[c].force_W.transpose();
      }
      load += AsVector(of_rows);
      EXPECT_LT(load.norm(), 2e-5 * of_rows.norm()) << stiffness << ' ' << i;
      last = U_;
    }
  }
}

TEST_F(SupportedBlockTest, ThePartInSeriesGivesTheComplianceAtOnce) {
  Build(1e6);
  constexpr double kR = 9;
  const Eigen::MatrixXd at_once = (K_ + kR * tissue_K_).inverse();
  for (const Vector3d& p : {Vector3d(0.12, 0.08, 0.1), Vector3d(0.03, 0.05, 0.0)}) {
    contacts_.Clear();
    AddContact(kGrasp, p, Vector3d::Zero());
    Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(K_.rows(), 3);
    for (int a = 0; a < lattice_.size(); ++a) {
      loads.middleRows<3>(3 * a) = contacts_.Weights()(0, a) * Matrix3d::Identity();
    }
    Eigen::MatrixXd response = loads;
    relaxation_->compliance()->SolveLoads(response);
    const Matrix3d C = loads.transpose() * response;
    const Matrix3d C_0 = supports_->InSeries(response, kR);
    const Matrix3d exact = loads.transpose() * at_once * loads;
    EXPECT_LT(((C + kR * C_0) / (1 + kR) - exact).norm(), 2e-5 * exact.norm());
    EXPECT_GT(C_0.norm(), 0.05 * C.norm());  // the springs matter
  }
}

TEST_F(SupportedBlockTest, StiffSpringsAreAsGoodAsTissueThatRelaxes) {
  Build(1e13);
  MaxwellMemory elastic(kTwoTerms, lattice_.size(), supports_);
  MaxwellMemory relaxing(kTwoTerms, lattice_.size());
  AddContact(kGrasp, {0.12, 0.08, 0.1}, Vector3d(0, 0, 0.004));
  for (int i = 0; i < 20; ++i) {
    elastic.Relax(0.033, relaxation_.get(), &contacts_, &U_);
    const Vector3d force = contacts_[0].force_W;
    relaxing.Relax(0.033, relaxation_.get(), &contacts_, &U_);
    EXPECT_LT((contacts_[0].force_W - force).norm(), 1e-3 * force.norm());
  }
}

}  // namespace
}  // namespace hpdm
