// A duct's path and ends: the rows of a lattice against fields that it reproduces, the rotation of an
// end against known ones, and what is refused.

#include "engine/duct/duct_model.h"

#include <gtest/gtest.h>

#include <string>

#include "engine/base/error.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

OrganOptions BlockOptions() {
  OrganOptions block;
  block.name = "block";
  block.lattice.cells = {3, 3, 2};
  block.lattice.margin = 0.0005;
  return block;
}

OrganModel Block(const OrganOptions& options = BlockOptions()) {
  return OrganModel(options, GridBox({-0.02, -0.02, -0.02}, {0.02, 0.02, 0}, {8, 8, 4}));
}

DuctOptions Duct(const Vector3d& start_W, const Vector3d& end_W) {
  DuctOptions duct;
  duct.name = "duct";
  duct.a = "block";
  duct.path_W.resize(2, 3);
  duct.path_W << start_W.transpose(), end_W.transpose();
  duct.radius = 0.002;
  duct.wall = 0.0008;
  duct.young = 1e6;
  return duct;
}

std::string RefusalOf(const DuctOptions& duct, const OrganModel& block) {
  try {
    const DuctModel model(duct, &block, nullptr);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(EvenPath, HasEqualSegmentsThroughThePoints) {
  Points path(4, 3);
  path << 0, 0, 0, 0.01, 0.004, 0, 0.015, 0.012, 0.003, 0.03, 0.01, 0.004;
  const Points even = EvenPath(path, 60);
  ASSERT_EQ(even.rows(), 61);
  EXPECT_EQ(even.row(0), path.row(0));
  EXPECT_EQ(even.row(60), path.row(3));
  const double first = (even.row(1) - even.row(0)).norm();
  for (int i = 0; i < 60; ++i) {
    EXPECT_NEAR((even.row(i + 1) - even.row(i)).norm(), first, 0.01 * first) << i;
  }
  for (int p = 0; p < 4; ++p) {
    EXPECT_LT((even.rowwise() - path.row(p)).rowwise().norm().minCoeff(), 0.6 * first) << p;
  }
}

TEST(EvenPath, OfTwoPointsIsStraight) {
  Points path(2, 3);
  path << 0.01, 0.02, 0.03, 0.05, 0.02, 0.03;
  const Points even = EvenPath(path, 10);
  for (int i = 0; i <= 10; ++i) {
    EXPECT_LT((even.row(i) - Eigen::RowVector3d(0.01 + 0.004 * i, 0.02, 0.03)).norm(), 1e-12) << i;
  }
}

// A displacement field u = t + A x moves the rows of an end by t + A p and by length A, also for an
// end that lies off the surface.
TEST(DuctModel, AnEndFollowsALinearField) {
  const OrganModel block = Block();
  const Lattice& lattice = block.lattice_organ()->lattice();
  const Matrix3d A = Matrix3d{{0.1, -0.2, 0.3}, {0.05, 0.15, -0.1}, {0.2, 0.1, -0.05}};
  const Vector3d t(0.01, 0.02, 0.03);
  Points U = lattice.ControlPoints() * A.transpose();
  U.rowwise() += t.transpose();
  for (const double height : {-0.004, 0.0, 0.0015}) {
    const Vector3d p_W(0.003, -0.002, height);
    const DuctModel model(Duct(p_W, Vector3d(0, 0, 0.04)), &block, nullptr);
    const DuctModel::Hold& hold = model.holds[0];
    for (int r = 0; r < DuctModel::Hold::kRows; ++r) {
      Vector3d moved = Vector3d::Zero();
      for (const auto& [column, value] : hold.rows[ToSize(r)]) moved += value * U.row(column);
      const Vector3d expected =
          r == 0 ? Vector3d(t + A * p_W) : Vector3d(hold.length * A.col(r - 1));
      EXPECT_LT((moved - expected).norm(), 1e-9) << height << " " << r;
    }
    EXPECT_FALSE(model.IsHeldByLattice(1));
  }
}

Eigen::Matrix<double, 12, 1> RowsOf(const Matrix3d& F, const Vector3d& way, double length) {
  Eigen::Matrix<double, 12, 1> w;
  w.head<3>() = way;
  for (int k = 0; k < 3; ++k) w.segment<3>(3 + 3 * k) = length * (F.col(k) - Vector3d::Unit(k));
  return w;
}

TEST(EndMotion, TakesTheRotationOfTheMaterial) {
  const Rod::Frame rest{Vector3d(0.01, 0.02, 0.03), RotationOf(Vector3d(0.4, 0.1, -0.2))};
  const Matrix3d R = RotationOf(Vector3d(-0.9, 0.5, 0.7));
  const Matrix3d stretch = Matrix3d{{1.2, 0.1, 0}, {0.1, 0.8, -0.05}, {0, -0.05, 1.1}};
  const EndMotion motion =
      EndMotionOf(rest, 0.008, RowsOf(R * stretch, Vector3d(1, 2, 3), 0.008), Matrix3d::Identity());
  EXPECT_LT((motion.turn - R).norm(), 1e-12);
  EXPECT_LT((motion.frame.R_W - R * rest.R_W).norm(), 1e-12);
  EXPECT_LT((motion.frame.p_W - rest.p_W - Vector3d(1, 2, 3)).norm(), 1e-12);
}

TEST(EndMotion, HasTheDerivativeOfTheRotation) {
  const Rod::Frame rest;
  const Matrix3d F = RotationOf(Vector3d(0.3, -0.6, 0.2)) *
                     Matrix3d{{1.2, 0.1, 0}, {0.1, 0.8, -0.05}, {0, -0.05, 1.1}};
  const Eigen::Matrix<double, 12, 1> w = RowsOf(F, Vector3d(0.001, 0, 0), 0.008);
  const EndMotion here = EndMotionOf(rest, 0.008, w, Matrix3d::Identity());
  for (int k = 0; k < 12; ++k) {
    constexpr double kStep = 1e-7;
    Eigen::Matrix<double, 12, 1> ahead = w, behind = w;
    ahead[k] += kStep;
    behind[k] -= kStep;
    const EndMotion to = EndMotionOf(rest, 0.008, ahead, Matrix3d::Identity());
    const EndMotion from = EndMotionOf(rest, 0.008, behind, Matrix3d::Identity());
    Eigen::Matrix<double, 6, 1> slope;
    slope << (to.frame.p_W - from.frame.p_W) / (2 * kStep),
        RotationVector(to.turn * from.turn.transpose()) / (2 * kStep);
    EXPECT_LT((slope - here.map.col(k)).norm(), 1e-5 * (1 + slope.norm())) << k;
  }
}

TEST(DuctModel, RefusesAnEndInTheAir) {
  const OrganModel block = Block();
  const std::string refusal = RefusalOf(Duct(Vector3d(0, 0, 0.005), Vector3d(0, 0, 0.04)), block);
  EXPECT_EQ(refusal,
            "duct \"duct\": its end a at [0.0000, 0.0000, 0.0050] lies in the air, 5 mm off organ "
            "\"block\"; move it into the organ or within the duct's radius of its surface");
}

TEST(DuctModel, RefusesAPathWithoutLength) {
  const OrganModel block = Block();
  EXPECT_EQ(RefusalOf(Duct(Vector3d(0, 0, 0), Vector3d(0, 0, 0.007)), block),
            "duct \"duct\": its path is 7 mm long; give more than 4 radii, 8 mm");
}

TEST(DuctModel, RefusesAPathThatDoublesBack) {
  const OrganModel block = Block();
  DuctOptions duct = Duct(Vector3d(0, 0, 0), Vector3d(0, 0, 0.01));
  duct.path_W.resize(3, 3);
  duct.path_W << 0, 0, 0, 0, 0, 0.03, 0, 0, 0.01;
  EXPECT_NE(RefusalOf(duct, block).find("turns by more than 90 degrees at [0.0000"),
            std::string::npos)
      << RefusalOf(duct, block);
}

}  // namespace
}  // namespace hpdm
