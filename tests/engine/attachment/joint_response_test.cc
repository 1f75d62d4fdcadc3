// The joined response of two organs against closed forms, and against a direct solve of both
// stiffnesses with the layer, without modes.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/attachment/attached_compliance.h"
#include "engine/base/error.h"
#include "engine/contact/surface_kernel.h"
#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

/// Two organs and the layer between them.
struct JoinedPair {
  JoinedPair(const OrganModel& a, const OrganModel& b, const AttachmentOptions& attachment,
             std::vector<std::shared_ptr<const DuctModel>> ducts = {}, std::size_t layers = 1)
      : models{&a, &b} {
    std::array<AttachmentJoint::Organ, 2> organs;
    for (std::size_t o = 0; o < 2; ++o) {
      if (models[o]->rigid()) {
        organs[o] = {static_cast<int>(o), 0, 0, nullptr};
        continue;
      }
      relaxations[o] = models[o]->MakeRelaxation(0);
      organs[o] = {static_cast<int>(o), models[o]->control_points(), models[o]->control_points(),
                   relaxations[o]->compliance()};
    }
    std::vector<AttachmentBed> beds;
    for (std::size_t l = 0; l < layers; ++l) beds.emplace_back(attachment, a, b);
    const std::vector<std::array<AttachmentJoint::Organ, 2>> pairs(layers + ducts.size(), organs);
    joint = JoinOrgans(std::move(beds), pairs, std::move(ducts))[0];
    state = std::make_unique<AttachmentState>(joint);
    work.MakeRoom(*joint);
  }

  const AttachmentBed& bed() const { return joint->layers()[0].bed; }

  /// Returns the displacements of both organs (3n) under loads on them (3n, N).
  std::array<Eigen::VectorXd, 2> Solve(const std::array<Eigen::VectorXd, 2>& loads) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(3 * joint->modes()), q = w;
    std::array<Eigen::VectorXd, 2> moved;
    for (std::size_t o = 0; o < 2; ++o) {
      const auto& member =
          joint->members()[static_cast<std::size_t>(joint->MemberOf(static_cast<int>(o)))];
      moved[o] = loads[o];
      if (member.unknowns() == 0) continue;
      w += member.response.transpose() * loads[o];
      relaxations[o]->compliance()->SolveLoads(moved[o]);
    }
    FewColumns w_0 = FewColumns::Zero(w.size(), kFewColumns), forces = w_0;
    w_0.col(0) = w;
    state->solver().FindForces(w_0, forces);
    q = forces.col(0);
    w -= joint->compliance().leftCols(q.size()) * q;
    for (std::size_t o = 0; o < 2; ++o) {
      const auto& member =
          joint->members()[static_cast<std::size_t>(joint->MemberOf(static_cast<int>(o)))];
      if (member.unknowns() > 0) moved[o] -= member.response * q;
    }
    modes = w;
    return moved;
  }

  std::array<const OrganModel*, 2> models;
  std::array<std::unique_ptr<Relaxation>, 2> relaxations;
  std::shared_ptr<const AttachmentJoint> joint;
  std::unique_ptr<AttachmentState> state;
  AttachedCompliance::Work work;
  Eigen::VectorXd modes;  // of the last Solve()
};

OrganOptions ArmOptions(const char* name, double young, std::array<int, 3> cells) {
  OrganOptions options;
  options.name = name;
  options.material = {.young = young, .poisson = 0};
  options.lattice.cells = cells;
  options.lattice.margin = 0;
  options.lattice.local.functions = 0;
  return options;
}

// Returns the row of the mean displacement of the face x = 0.
Eigen::RowVectorXd EndRow(const OrganModel& arm) {
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(arm.control_points());
  double count = 0;
  for (int v = 0; v < arm.rest().vertices.rows(); ++v) {
    if (std::abs(arm.rest().vertices(v, 0)) > 1e-9) continue;
    const SparseRow b = arm.LatticeRow(v);
    for (std::size_t i = 0; i < b.weights.size(); ++i) row[b.control_points[i]] += b.weights[i];
    count += 1;
  }
  return row / count;
}

Eigen::VectorXd Along(const Eigen::RowVectorXd& row, const Vector3d& force) {
  Eigen::VectorXd load(3 * row.size());
  for (Eigen::Index a = 0; a < row.size(); ++a) load.segment<3>(3 * a) = row[a] * force;
  return load;
}

struct CantileverCase {
  double lambda_h, crack, height, size;
};
class DoubleCantilever : public testing::TestWithParam<CantileverCase> {};

// Two equal slender arms, apart over the length a, on a layer over the rest: beams on an elastic
// foundation of stiffness 2 k B for each arm's deflection, which is half of the opening.
TEST_P(DoubleCantilever, TipYieldsAsBeamsOnAnElasticFoundation) {
  const CantileverCase& c = GetParam();
  const double young = 1e5, h = c.height * c.size, B = 2.5 * h, crack = c.crack * h;
  const double lambda = c.lambda_h / h, length = crack + 7 / lambda;
  const int cells = static_cast<int>(std::ceil(length / h));
  std::vector<OrganModel> arms;
  for (const double side : {-1.0, 1.0}) {
    const Vector3d low(0, 0, side < 0 ? -h : 0), high(length, B, side < 0 ? 0 : h);
    OrganOptions arm = ArmOptions(side < 0 ? "lower" : "upper", young, {cells, 1, 2});
    // The far end does not move.
    arm.supports.push_back(
        {hpdm::Box{Vector3d(length - h, -1, -1), Vector3d(2 * length, 1, 1)}, {}});
    arms.emplace_back(arm, GridBox(low, high, {2 * cells, 5, 2}));
  }
  AttachmentOptions attachment;
  attachment.a = "lower";
  attachment.b = "upper";
  attachment.region = hpdm::Box{Vector3d(crack, -1, -1), Vector3d(length - 1.05 * h, 1, 1)};
  attachment.thickness = 0.001;
  // lambda^4 = 2 k B / (4 E I), I = B h^3 / 12.
  attachment.young = std::pow(c.lambda_h, 4) * young / (6 * h) * attachment.thickness;
  attachment.strength = 1e6;
  attachment.toughness = 1e9;
  attachment.reach = 0.2 * h;
  JoinedPair pair(arms[0], arms[1], attachment);
  const Eigen::RowVectorXd row[2] = {EndRow(arms[0]), EndRow(arms[1])};
  const auto moved =
      pair.Solve({Along(row[0], Vector3d(0, 0, -1)), Along(row[1], Vector3d(0, 0, 1))});
  const double opening = Along(row[1], Vector3d::UnitZ()).dot(moved[1]) -
                         Along(row[0], Vector3d::UnitZ()).dot(moved[0]);
  const double I = B * h * h * h / 12;
  const double exact = 2 / (young * I) *
                       (std::pow(crack, 3) / 3 + crack * crack / lambda +
                        crack / (lambda * lambda) + 1 / (2 * std::pow(lambda, 3)));
  EXPECT_NEAR(opening / exact, 1, 0.03);
}

INSTANTIATE_TEST_SUITE_P(Cases, DoubleCantilever,
                         testing::Values(CantileverCase{0.30, 10, 0.004, 1},
                                         CantileverCase{0.22, 12, 0.004, 1},
                                         CantileverCase{0.25, 8, 0.004, 5}));

struct Blocks {
  explicit Blocks(double poisson = 0.3, int finer = 1) {
    OrganOptions lower = ArmOptions("lower", 5000, {3 * finer, 3 * finer, 2 * finer});
    lower.material.poisson = poisson;
    lower.supports.push_back({hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, -0.015)}, {}});
    OrganOptions upper = ArmOptions("upper", 9000, {4 * finer, 3 * finer, 2 * finer});
    upper.material.poisson = poisson;
    models.emplace_back(lower,
                        GridBox(Vector3d(-0.03, -0.03, -0.02), Vector3d(0.03, 0.03, 0), {9, 9, 4}));
    models.emplace_back(
        upper, GridBox(Vector3d(-0.02, -0.025, 0.0005), Vector3d(0.025, 0.02, 0.02), {8, 8, 4}));
  }
  std::vector<OrganModel> models;
  AttachmentOptions attachment =
      BedLayer("lower", "upper",
               hpdm::Box{Vector3d(-0.018, -0.02, -0.001), Vector3d(0.022, 0.014, 0.001)}, 0.002);
};

// Returns both stiffnesses with the layer's springs, sample by sample.
Eigen::MatrixXd DirectStiffness(const std::vector<OrganModel>& models, const AttachmentBed& bed,
                                const AttachmentState& state) {
  const Eigen::Index n[2] = {models[0].control_points(), models[1].control_points()};
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * (n[0] + n[1]), 3 * (n[0] + n[1]));
  K.topLeftCorner(3 * n[0], 3 * n[0]) = std::get<FullStiffness>(models[0].stiffness());
  K.bottomRightCorner(3 * n[1], 3 * n[1]) = std::get<FullStiffness>(models[1].stiffness());
  for (int i = 0; i < bed.size(); ++i) {
    Eigen::RowVectorXd J(n[0] + n[1]);
    J << -Eigen::RowVectorXd(bed.rows[0].row(i)), Eigen::RowVectorXd(bed.rows[1].row(i));
    const double d = state.damage()[static_cast<std::size_t>(i)];
    const Vector3d normal = bed.normals_W.row(i);
    Matrix3d k = (1 - d) * Matrix3d::Identity();
    if (state.closed()[static_cast<std::size_t>(i)] != 0) k += d * normal * normal.transpose();
    k *= bed.areas[i] * bed.law.stiffness;
    for (Eigen::Index a = 0; a < J.size(); ++a) {
      for (Eigen::Index b = 0; b < J.size(); ++b) {
        if (J[a] * J[b] != 0) K.block<3, 3>(3 * a, 3 * b) += J[a] * J[b] * k;
      }
    }
  }
  return K;
}

TEST(JointResponse, IsThatOfBothStiffnessesWithTheLayerAtAnyDamage) {
  Blocks blocks;
  JoinedPair pair(blocks.models[0], blocks.models[1], blocks.attachment);
  for (const double pull : {0.0, 0.3, 1.5}) {
    std::array<Eigen::VectorXd, 2> loads;
    for (std::size_t o = 0; o < 2; ++o) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(blocks.models[o].control_points());
      blocks.models[o].AddToRow(
          NearestSurfacePoint(blocks.models[o].rest(),
                              o == 0 ? Vector3d(-0.03, 0.01, -0.005) : Vector3d(0.02, -0.01, 0.02)),
          1, ActiveRefinement(0, 0), row);
      loads[o] = Along(row, o == 0 ? Vector3d(0.1, 0.05, 0.02) : Vector3d(0.02, -0.05, 1 + pull));
    }
    if (pull > 0) {  // some samples fail, others in part
      pair.Solve(loads);
      EXPECT_FALSE(pair.state->Update(pair.modes));
      pair.state->Refactor();
      EXPECT_GT(*std::ranges::max_element(pair.state->damage()), 0.5);
      EXPECT_LT(*std::ranges::min_element(pair.state->damage()), 0.5);
    }
    const Eigen::MatrixXd K = DirectStiffness(blocks.models, pair.bed(), *pair.state);
    Eigen::VectorXd load(K.rows());
    load << loads[0], loads[1];
    const Eigen::VectorXd direct = K.llt().solve(load);
    const auto moved = pair.Solve(loads);
    // The modes that are dropped.
    Eigen::VectorXd joined(K.rows());
    joined << moved[0], moved[1];
    EXPECT_LT((joined - direct).norm(), 3e-3 * direct.norm()) << pull;
  }
}

// Only the layer holds the upper block, whose own compliance is 190 times larger. Two soft ducts end
// side by side, so that their modes nearly depend on each other and G^-1 is large. Jaws hold the upper
// block at four points: their compliance is a difference that must keep its digits.
TEST(JointResponse, JawsOnAnOrganThatOnlyItsLayerHoldsHaveTheComplianceOfBothStiffnesses) {
  Blocks blocks(0.3, 2);
  std::vector<std::shared_ptr<const DuctModel>> ducts;
  for (const double y : {0.0, 0.003}) {
    DuctOptions duct;
    duct.a = "lower";
    duct.b = "upper";
    duct.path_W.resize(2, 3);
    duct.path_W << -0.03, 4 * y, -0.005, -0.02, y, 0.01;
    duct.radius = 0.002;
    duct.wall = 0.001;
    duct.young = 1e-3;  // hardly anything
    ducts.push_back(std::make_shared<const DuctModel>(duct, &blocks.models[0], &blocks.models[1]));
  }
  JoinedPair pair(blocks.models[0], blocks.models[1], blocks.attachment, std::move(ducts));
  pair.work.MakeRoom(*pair.joint, 12);
  const OrganModel& upper = blocks.models[1];
  const LatticeCompliance& free = *pair.relaxations[1]->compliance();
  const AttachedCompliance attached(free, *pair.state, pair.joint->MemberOf(1), &pair.work);
  const int n = upper.control_points();
  const Eigen::MatrixXd K = DirectStiffness(blocks.models, pair.bed(), *pair.state);
  const Eigen::LLT<Eigen::MatrixXd> direct(K);
  Eigen::MatrixXd responses(3 * n, 12), loads(K.rows(), 12);
  RowMajorMatrix rows = RowMajorMatrix::Zero(4, n);
  std::vector<std::vector<int>> columns(4);
  std::vector<std::vector<double>> weights(4);
  loads.setZero();
  for (int i = 0; i < 4; ++i) {
    const Vector3d place(0.001 * (i % 2), 0.001 * (i / 2), 0.02);
    upper.AddToRow(NearestSurfacePoint(upper.rest(), place), 1, ActiveRefinement(0, 0),
                   rows.row(i));
    for (int a = 0; a < n; ++a) {
      if (rows(i, a) == 0) continue;
      columns[ToSize(i)].push_back(a);
      weights[ToSize(i)].push_back(rows(i, a));
      for (int d = 0; d < 3; ++d) loads(K.rows() - 3 * n + 3 * a + d, 3 * i + d) = rows(i, a);
    }
  }
  std::array<SparseRow, 4> set;
  for (std::size_t i = 0; i < 4; ++i) set[i] = {columns[i], weights[i]};
  attached.RespondInPart(set, responses);
  const auto of_rows = [&](const Eigen::MatrixXd& of_points) {
    Eigen::MatrixXd C(12, 12);
    for (int i = 0; i < 4; ++i) {
      for (int d = 0; d < 3; ++d) {
        C.row(3 * i + d) = Along(rows.row(i), Vector3d::Unit(d)).transpose() * of_points;
      }
    }
    return C;
  };
  Eigen::MatrixXd C = of_rows(responses);
  const double without = C(0, 0);
  attached.AddOtherPart(Eigen::Ref<Eigen::MatrixXd>(C));
  const Eigen::MatrixXd exact = of_rows(direct.solve(loads).bottomRows(3 * n));
  EXPECT_GT(without, 100 * exact(0, 0));
  const Eigen::MatrixXd G = pair.joint->compliance().leftCols(3 * pair.joint->modes());
  const Eigen::VectorXd yields_of_modes = G.selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_LT(yields_of_modes[0], 1e-12 * yields_of_modes.tail(1)[0]) << "modes nearly depend";
  EXPECT_LT((C - exact).norm(), 3e-3 * exact.norm());
  // Along the combination of loads that yields least.
  const Eigen::VectorXd least =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(exact).eigenvectors().col(0);
  const double yields = least.dot(exact * least);
  EXPECT_NEAR(least.dot(C * least), yields, 0.01 * yields);
}

TEST(JointResponse, LayersOnTheSameSurfaceActTogether) {
  const Blocks blocks;
  AttachmentOptions half = blocks.attachment;
  half.young /= 2;
  JoinedPair one(blocks.models[0], blocks.models[1], blocks.attachment);
  JoinedPair two(blocks.models[0], blocks.models[1], half, {}, 2);
  std::array<Eigen::VectorXd, 2> loads;
  for (std::size_t o = 0; o < 2; ++o) {
    loads[o] = Eigen::VectorXd::LinSpaced(3 * blocks.models[o].control_points(), -1, 2);
  }
  const auto expected = one.Solve(loads), moved = two.Solve(loads);
  for (std::size_t o = 0; o < 2; ++o) {
    EXPECT_LT((moved[o] - expected[o]).norm(), 1e-3 * expected[o].norm());
  }
}

}  // namespace
}  // namespace hpdm
