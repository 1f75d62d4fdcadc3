#include "engine/solver/maxwell_memory.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "engine/energy/finite_strain_energy.h"
#include "engine/solver/elastic_relaxation.h"
#include "tests/support/prony.h"
#include "tests/support/relaxation_fixture.h"

namespace hpdm {
namespace {

const PronySeries kThreeTerms = Prony({{0.3, 0.02}, {0.2, 0.5}, {0.25, 20}});
constexpr double kLongTerm = 0.25;  // 1 - sum g

// Force over the relaxed one at `t` (s) after a motion at constant speed over the first `ramp` (s).
double Law(const PronySeries& prony, double t, double ramp) {
  double law = 1;
  for (int k = 0; k < prony.count; ++k) {
    const auto& [share, time] = prony.terms[static_cast<std::size_t>(k)];
    law += share / (1 - prony.Share()) * time / ramp *
           (std::exp(-(t - ramp) / time) - std::exp(-t / time));
  }
  return law;
}

// The block of the fixture, of strain energy, with contacts on its top.
class MaxwellMemoryTest : public ContactBlockTest {
 protected:
  void SetUp() override {
    FullStiffness K = StrainStiffness(lattice_, tissue_, {}, Dilatation::kProjected);
    AddAlongEachAxis(supports_, &K);
    elastic_ = MakeCholeskyRelaxation(K);
  }
  MaxwellMemory Memory(const PronySeries& prony) const { return {prony, lattice_.size()}; }
  Vector3d ElasticForce(int row = 0) {  // of the present contacts
    Points U = U_;
    elastic_->Relax(&contacts_, &U);
    return contacts_[row].force_W;
  }
  Vector3d Moved() const { return PositionOf(0) - contacts_[0].p_rest_W; }

  const Vector3d p_{0.12, 0.08, 0.1};
  const Quadrature tissue_ = BoxQuadrature(Block(), {12, 12, 12});
  const ScalarStiffness supports_ = Supports(lattice_, tissue_, 5000);
  std::unique_ptr<Relaxation> elastic_;
};

TEST_F(MaxwellMemoryTest, AHeldMotionRelaxesByTheLawInStepsOfAnyLength) {
  const Vector3d lift(0.01, 0, 0.02);
  for (const double dt : {0.0005, 0.01, 0.1, 3.0}) {
    MaxwellMemory memory = Memory(kThreeTerms);
    contacts_.Clear();
    AddContact(kGrasp, p_, lift);
    const Vector3d relaxed = ElasticForce();
    for (int i = 1; i <= 100; ++i) {
      memory.Relax(dt, elastic_.get(), &contacts_, &U_);
      EXPECT_LT((Moved() - lift).norm(), 1e-9);
      const Vector3d law = Law(kThreeTerms, i * dt, dt) * relaxed;
      ASSERT_LT((contacts_[0].force_W - law).norm(), 1e-8 * law.norm()) << dt << ' ' << i;
    }
  }
}

TEST_F(MaxwellMemoryTest, AVariedStepStillFollowsTheLaw) {
  MaxwellMemory memory = Memory(kThreeTerms);
  const Vector3d speed(0, 0.01, 0.05);
  double t = 0;
  for (const double dt : {0.033, 0.002, 0.4, 0.033, 0.1}) {
    t += dt;
    contacts_.Clear();
    AddContact(kGrasp, p_, t * speed);
    const Vector3d relaxed = ElasticForce();
    memory.Relax(dt, elastic_.get(), &contacts_, &U_);
    const Vector3d law = Law(kThreeTerms, t, t) * relaxed;
    EXPECT_LT((contacts_[0].force_W - law).norm(), 1e-9 * law.norm()) << t;
  }
}

TEST_F(MaxwellMemoryTest, ReleasedTissueReturnsInTime) {
  constexpr double kShare = 0.6, kTau = 0.2, kStep = 0.002;
  MaxwellMemory memory = Memory(Prony({{kShare, kTau}}));
  AddContact(kGrasp, p_, Vector3d(0.01, 0, 0.02));
  for (int i = 0; i < 30; ++i) memory.Relax(0.2, elastic_.get(), &contacts_, &U_);
  const Points held = U_;
  contacts_.Clear();
  for (int i = 1; i <= 200; ++i) {
    memory.Relax(kStep, elastic_.get(), &contacts_, &U_);
    // The share that had relaxed is left at once. It goes with tau / (1 - g); the release took half
    // a step on average.
    const double left = kShare * std::exp(-(i - 0.5) * kStep * (1 - kShare) / kTau);
    ASSERT_LT((U_ - left * held).norm(), 2e-3 * held.norm()) << i;
  }
  EXPECT_FALSE(memory.AtRest());
  for (int i = 0; i < 300; ++i) memory.Relax(0.1, elastic_.get(), &contacts_, &U_);
  EXPECT_TRUE(memory.AtRest());
  EXPECT_TRUE(U_.isZero(0));
}

TEST_F(MaxwellMemoryTest, ATipThatWithdrawsFasterThanTheTissueLosesIt) {
  MaxwellMemory memory = Memory(Prony({{0.5, 0.5}}));
  AddContact(kPress, p_, Vector3d(0, 0, -0.02));
  for (int i = 0; i < 300; ++i) memory.Relax(0.033, elastic_.get(), &contacts_, &U_);
  EXPECT_LT(contacts_[0].force_W.z(), 0);
  contacts_.Clear();
  AddContact(kPress, p_, Vector3d(0, 0, -0.001));
  memory.Relax(0.033, elastic_.get(), &contacts_, &U_);
  EXPECT_EQ(contacts_[0].force_W.norm(), 0);
  EXPECT_NEAR(Moved().z(), -0.01, 5e-4);
}

TEST_F(MaxwellMemoryTest, ADentAndAFootprintRelaxByTheSameLaw) {
  LocalCoupling coupling = 2e-3 * LocalCoupling::Identity(6, 6);
  coupling.topRightCorner<3, 3>() = coupling.bottomLeftCorner<3, 3>() = 5e-4 * Matrix3d::Identity();
  const auto add = [&] {
    contacts_.Clear();
    AddContact(kPress, {0.05, 0.05, 0.1}, Vector3d(0, 0, -0.006));
    contacts_[0].indentation = LocalIndentation({}, Vector3d::UnitZ(), 0.0025, 0.03);
    for (int i = 0; i < 2; ++i) {
      AddContact(kGrasp, Vector3d(0.14, 0.08 + 0.01 * i, 0.1), Vector3d(0.002, 0, 0.004));
      contacts_[1 + i].tool = 1;
      contacts_[1 + i].local_compliance_W = coupling.block<3, 3>(3 * i, 3 * i);
      contacts_[1 + i].coupled = {&coupling, i};
    }
  };
  MaxwellMemory memory = Memory(kThreeTerms);
  add();
  const std::vector<Vector3d> relaxed = {ElasticForce(0), ElasticForce(1), ElasticForce(2)};
  constexpr double kStep = 0.03;
  for (int step = 1; step <= 60; ++step) {
    add();
    memory.Relax(kStep, elastic_.get(), &contacts_, &U_);
    for (int i = 0; i < 3; ++i) {
      const Vector3d law =
          Law(kThreeTerms, step * kStep, kStep) * relaxed[static_cast<std::size_t>(i)];
      ASSERT_LT((contacts_[i].force_W - law).norm(), 1e-5 * law.norm()) << step << ' ' << i;
    }
    // The rows are given back as they were.
    EXPECT_LT((contacts_[1].local_compliance_W - coupling.block<3, 3>(0, 0)).norm(), 1e-15);
    EXPECT_EQ(contacts_[1].coupled.coupling, &coupling);
  }
}

TEST_F(MaxwellMemoryTest, SmallMotionsOfFiniteStrainFollowTheSameLaw) {
  FiniteStrainEnergy energy(lattice_, tissue_, MaterialLaw::kNeoHookean, ToLame({}),
                            Dilatation::kProjected, supports_);
  const std::unique_ptr<Relaxation> newton = MakeNewtonRelaxation(energy, {.max_iterations = 20});
  MaxwellMemory memory = Memory(kThreeTerms);
  AddContact(kGrasp, p_, Vector3d(1e-5, 0, 2e-5));
  const Vector3d relaxed = ElasticForce();
  constexpr double kStep = 0.03;
  for (int step = 1; step <= 12; ++step) {
    memory.Relax(kStep, newton.get(), &contacts_, &U_);
    const Vector3d law = Law(kThreeTerms, step * kStep, kStep) * relaxed;
    ASSERT_LT((contacts_[0].force_W - law).norm(), 2e-3 * law.norm()) << step;
  }
}

TEST_F(MaxwellMemoryTest, WithoutTermsTheResultIsElasticToTheLastBit) {
  MaxwellMemory memory = Memory({});
  AddContact(kGrasp, p_, Vector3d(0.01, 0, 0.02));
  memory.Relax(0.033, elastic_.get(), &contacts_, &U_);
  const Points result = U_;
  elastic_->Relax(&contacts_, &U_);
  EXPECT_EQ(result, U_);
  EXPECT_TRUE(memory.AtRest());
}

}  // namespace
}  // namespace hpdm
