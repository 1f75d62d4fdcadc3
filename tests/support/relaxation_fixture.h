#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "engine/solver/relaxation.h"
#include "engine/tissue/support.h"

namespace hpdm {

inline constexpr auto kGrasp = ContactConstraints::RowKind::kGrasp;
inline constexpr auto kPress = ContactConstraints::RowKind::kPress;

/// The lattice of a 0.2 x 0.15 x 0.1 m block, with a few contacts.
class ContactBlockTest : public testing::Test {
 protected:
  ContactBlockTest() : contacts_(lattice_.size()), U_(Points::Zero(lattice_.size(), 3)) {}

  static OrientedBox Block() {
    return {Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.15, 0.1)};
  }
  /// Supports that hold the bottom fifth of `tissue`.
  static ScalarStiffness Supports(const Lattice& lattice, const Quadrature& tissue,
                                  double modulus) {
    OrientedBox bottom = Block();
    bottom.lengths.z() *= 0.2;
    return SupportStiffness(lattice, tissue, {SupportOptions()},
                            {BoxQuadrature(bottom, {12, 12, 6})}, modulus);
  }

  void AddContact(ContactConstraints::RowKind kind, const Vector3d& p, const Vector3d& move) {
    ContactConstraints::Row* row = contacts_.Add();
    ASSERT_NE(row, nullptr);
    row->kind = kind;
    row->p_rest_W = p;
    row->target_W = p + move;
    contacts_.WeightRow(contacts_.size() - 1) = lattice_.Weights(p.transpose()).toDense().row(0);
  }
  Vector3d PositionOf(int i) const {
    return contacts_[i].p_rest_W + (contacts_.Weights().row(i) * U_).transpose();
  }

  Lattice lattice_{Block(), LatticeOptions()};
  ContactConstraints contacts_;
  Points U_;
};

/// The block held at its bottom, with the metric energy.
class RelaxationTest : public ContactBlockTest {
 protected:
  static Quadrature Tissue() { return BoxQuadrature(Block(), {12, 12, 12}); }
  static ScalarStiffness Stiffness(const Lattice& lattice) {
    return MetricStiffness(lattice, Tissue(), 2000, 0.05) + Supports(lattice, Tissue(), 2000);
  }

  ScalarStiffness K_ = Stiffness(lattice_);
  std::unique_ptr<Relaxation> cholesky_ = MakeCholeskyRelaxation(K_);
  std::unique_ptr<Relaxation> gauss_seidel_ = MakeGaussSeidelRelaxation(K_, {.tolerance = 1e-9});
};

/// The same block with the strain energy: stiff against volume change, coupled axes.
class StrainRelaxationTest : public RelaxationTest {
 protected:
  static FullStiffness StrainWithSupports(const Lattice& lattice) {
    FullStiffness K = StrainStiffness(lattice, Tissue(), {}, Dilatation::kProjected);
    AddAlongEachAxis(Supports(lattice, Tissue(), MaterialOptions().young), &K);
    return K;
  }
  Eigen::VectorXd Load() const {
    Points load = Points::Zero(lattice_.size(), 3);
    for (int i = 0; i < contacts_.size(); ++i) {
      load += contacts_.Weights().row(i).transpose() * contacts_[i].force_W.transpose();
    }
    return Eigen::Map<const Eigen::VectorXd>(load.data(), load.size());
  }

  FullStiffness K_full_ = StrainWithSupports(lattice_);
  std::unique_ptr<Relaxation> full_ = MakeCholeskyRelaxation(K_full_);
};

}  // namespace hpdm
