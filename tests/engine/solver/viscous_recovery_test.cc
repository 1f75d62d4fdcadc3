#include "engine/solver/viscous_recovery.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/tissue/support.h"

namespace hpdm {
namespace {

constexpr double kTau = 0.2;  // s

// A 0.2 x 0.15 x 0.1 m block held at its bottom, with one contact on its top.
class ViscousRecoveryTest : public testing::Test {
 protected:
  ViscousRecoveryTest() : contacts_(lattice_.size()), U_(Points::Zero(lattice_.size(), 3)) {
    const Quadrature tissue = BoxQuadrature(lattice_.box(), {12, 12, 12});
    OrientedBox bottom = lattice_.box();
    bottom.lengths.z() *= 0.2;
    FullStiffness K = StrainStiffness(lattice_, tissue, {}, Dilatation::kProjected);
    AddAlongEachAxis(SupportStiffness(lattice_, tissue, {SupportOptions()},
                                      {BoxQuadrature(bottom, {12, 12, 6})}, 5000),
                     &K);
    elastic_ = MakeCholeskyRelaxation(K);
  }

  void Hold(ContactConstraints::RowKind kind, const Vector3d& move) {
    const Vector3d p(0.12, 0.08, 0.1);
    contacts_.Clear();
    ContactConstraints::Row* row = contacts_.Add();
    row->kind = kind;
    row->p_rest_W = p;
    row->target_W = p + move;
    contacts_.WeightRow(0) = lattice_.Weights(p.transpose()).toDense().row(0);
  }
  Vector3d Displacement() const { return (contacts_.Weights().row(0) * U_).transpose(); }
  Vector3d ElasticForce() {  // of the present contact
    Points U = U_;
    elastic_->Relax(&contacts_, &U);
    return contacts_[0].force_W;
  }

  Lattice lattice_{{Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.15, 0.1)}, {}};
  std::unique_ptr<Relaxation> elastic_;
  ContactConstraints contacts_;
  Points U_;
};

using enum ContactConstraints::RowKind;

TEST_F(ViscousRecoveryTest, ReleasedTissueDecaysExponentiallyAtAnyStepLength) {
  const Vector3d lift(0.01, 0, 0.02);
  for (const double dt : {0.0005, 0.01, 0.1, 1.0}) {
    ViscousRecovery recovery(kTau, lattice_.size());
    Hold(kGrasp, lift);
    recovery.Relax(0.033, elastic_.get(), &contacts_, &U_);
    const Points held = U_;
    contacts_.Clear();
    const int steps = static_cast<int>(std::lround(1 / dt));
    for (int i = 0; i < steps; ++i) recovery.Relax(dt, elastic_.get(), &contacts_, &U_);
    // Round-off of 2,000 products.
    EXPECT_LT((U_ - std::exp(-1 / kTau) * held).norm(), 1e-12 * held.norm());
  }
}

TEST_F(ViscousRecoveryTest, ContactsHoldExactlyAndTheForceSettlesToTheElasticOne) {
  const Vector3d lift(0.01, 0, 0.02);
  ViscousRecovery recovery(kTau, lattice_.size());
  Hold(kGrasp, lift);
  const Vector3d settled = ElasticForce();
  const double dt = 0.033;
  for (int i = 0; i < 200; ++i) {
    recovery.Relax(dt, elastic_.get(), &contacts_, &U_);
    EXPECT_LT((Displacement() - lift).norm(), 1e-9);
    EXPECT_EQ(contacts_[0].target_W, contacts_[0].p_rest_W + lift);
    if (i == 0) {
      // All of it moved in this step.
      const Vector3d first = settled / (1 - std::exp(-dt / kTau));
      EXPECT_LT((contacts_[0].force_W - first).norm(), 1e-6 * first.norm());
    }
  }
  EXPECT_LT((contacts_[0].force_W - settled).norm(), 1e-6 * settled.norm());
}

TEST_F(ViscousRecoveryTest, ASteadyMoveFeelsStiffnessAndDamping) {
  // f = S (delta + tau d delta/dt), with force and displacement at the middle of each short step.
  ViscousRecovery recovery(kTau, lattice_.size());
  const Vector3d speed(0, 0, 0.05);
  Hold(kGrasp, Vector3d(0, 0, 1));
  const double stiffness = ElasticForce().z();
  constexpr double kStep = 0.001;
  for (int i = 1; i <= 500; ++i) {
    Hold(kGrasp, i * kStep * speed);
    recovery.Relax(kStep, elastic_.get(), &contacts_, &U_);
  }
  // Only the coupling with the tangential directions, also held, and the step remain.
  const double expected = stiffness * (speed.z() * 499.5 * kStep + kTau * speed.z());
  EXPECT_NEAR(contacts_[0].force_W.z() / expected, 1, 1e-3);
}

TEST_F(ViscousRecoveryTest, ATipThatWithdrawsFasterThanTheTissueLosesIt) {
  ViscousRecovery recovery(kTau, lattice_.size());
  Hold(kPress, Vector3d(0, 0, -0.02));
  for (int i = 0; i < 30; ++i) recovery.Relax(0.033, elastic_.get(), &contacts_, &U_);
  EXPECT_LT(contacts_[0].force_W.z(), 0);
  Hold(kPress, Vector3d(0, 0, -0.001));
  recovery.Relax(0.033, elastic_.get(), &contacts_, &U_);
  EXPECT_EQ(contacts_[0].force_W.norm(), 0);
  EXPECT_NEAR(Displacement().z(), -0.02 * std::exp(-0.033 / kTau), 1e-9);
}

TEST_F(ViscousRecoveryTest, WithoutRelaxationTimeTheResultIsElastic) {
  ViscousRecovery recovery(0, lattice_.size());
  Hold(kGrasp, Vector3d(0.01, 0, 0.02));
  recovery.Relax(0.033, elastic_.get(), &contacts_, &U_);
  const Points result = U_;
  elastic_->Relax(&contacts_, &U_);
  EXPECT_EQ(result, U_);
}

}  // namespace
}  // namespace hpdm
