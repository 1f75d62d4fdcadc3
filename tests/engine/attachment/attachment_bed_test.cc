#include "engine/attachment/attachment_bed.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "engine/base/error.h"
#include "tests/support/bed_layer.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

/// A plate and a ball of radius 30 mm over it, apart by 0.2 mm.
struct BallOnPlate {
  BallOnPlate() {
    OrganOptions options;
    options.lattice.cells = {4, 4, 3};
    options.lattice.local.functions = 0;
    options.name = "plate";
    plate.emplace_back(
        options, GridBox(Vector3d(-0.06, -0.06, -0.02), Vector3d(0.06, 0.06, 0), {18, 18, 4}));
    Isometry3d X = Isometry3d::Identity();
    X.translation().z() = 0.0302;
    options.name = "ball";
    options.lattice.cells = {6, 6, 6};
    plate.emplace_back(options, Ellipsoid(Vector3d::Constant(0.03), 4, X));
  }
  const OrganModel& ball() const { return plate[1]; }
  std::vector<OrganModel> plate;
  AttachmentOptions attachment =
      BedLayer("ball", "plate", hpdm::Box{Vector3d(-1, -1, -1), Vector3d(1, 1, 1)}, 0.004);
};

// A cap of a sphere of radius R whose points lie within the reach of the plane has the area
// 2 pi R (reach - gap).
TEST(AttachmentBed, CoversWhatFacesWithinTheReach) {
  BallOnPlate bodies;
  const AttachmentBed bed(bodies.attachment, bodies.ball(), bodies.plate[0]);
  const double area = 2 * 3.14159265 * 0.03 * (0.004 - 0.0002);
  EXPECT_NEAR(bed.areas.sum(), area, 0.04 * area);
  EXPECT_LE(bed.size(), AttachmentBed::kMaxSamples);
  EXPECT_GT(bed.size(), 100);
  for (int i = 0; i < bed.size(); ++i) {
    const Vector3d on_ball = bed.points_W[0].row(i), on_plate = bed.points_W[1].row(i);
    EXPECT_NEAR(on_plate.z(), 0, 1e-9);
    EXPECT_LT((on_ball - on_plate).head(2).norm(), 1e-9) << "the closest points";
    EXPECT_LT(bed.normals_W(i, 2), -0.85) << "from the ball to the plate";
  }
}

// Splines give affine displacements of the control points as such, so a sample moves as its point.
TEST(AttachmentBed, RowsMoveSamplesAsTheirPoints) {
  BallOnPlate bodies;
  const AttachmentBed bed(bodies.attachment, bodies.ball(), bodies.plate[0]);
  Matrix3d A;
  A << 0.1, 0.3, -0.2, 0.05, -0.1, 0.2, 0.3, 0.1, 0.15;
  const OrganModel* organs[2] = {&bodies.ball(), &bodies.plate[0]};
  for (std::size_t o = 0; o < 2; ++o) {
    const Points controls = organs[o]->lattice_organ()->lattice().ControlPoints();
    const Points moved = bed.rows[o] * (controls * A.transpose());
    EXPECT_LT((moved - bed.points_W[o] * A.transpose()).cwiseAbs().maxCoeff(), 1e-4 * 0.1);
    EXPECT_LT(
        (bed.rows[o] * Eigen::VectorXd::Ones(controls.rows()) - Eigen::VectorXd::Ones(bed.size()))
            .cwiseAbs()
            .maxCoeff(),
        1e-12);
  }
}

std::string FaultOf(const std::function<void()>& build) {
  try {
    build();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(AttachmentBed, RefusesWhatItCannotHold) {
  BallOnPlate bodies;
  const auto fault = [&](const AttachmentOptions& attachment, const OrganModel& plate) {
    return FaultOf([&] { AttachmentBed(attachment, bodies.ball(), plate); });
  };
  AttachmentOptions off = bodies.attachment;
  off.region = hpdm::Box{Vector3d(-1, -1, 0.05), Vector3d(1, 1, 1)};
  EXPECT_NE(fault(off, bodies.plate[0]).find("has none of \"plate\" within 4 mm"),
            std::string::npos);
  AttachmentOptions small = bodies.attachment;
  small.region = Sphere{Vector3d(0, 0, 0), 0.003};
  EXPECT_NE(fault(small, bodies.plate[0]).find("meets less than one function"), std::string::npos);
  OrganOptions held = bodies.plate[0].options();
  held.supports.push_back({Sphere{Vector3d(0.009, 0, 0), 0.005}, {}});
  EXPECT_NE(fault(bodies.attachment, OrganModel(held, bodies.plate[0].rest()))
                .find("overlaps support[0] of organ \"plate\""),
            std::string::npos);
}

TEST(AttachmentBed, RefusesASurfaceThatAnotherHas) {
  BallOnPlate bodies;
  AttachmentOptions left = bodies.attachment, right = bodies.attachment;
  left.region = hpdm::Box{Vector3d(-1, -1, -1), Vector3d(-0.0005, 1, 1)};
  right.region = hpdm::Box{Vector3d(0.0005, -1, -1), Vector3d(1, 1, 1)};
  const AttachmentBed whole(bodies.attachment, bodies.ball(), bodies.plate[0]);
  const AttachmentBed first(left, bodies.ball(), bodies.plate[0]);
  const AttachmentBed second(right, bodies.ball(), bodies.plate[0]);
  EXPECT_EQ(FaultOf([&] { RefuseSharedSurface(first, second); }), "");
  EXPECT_NE(FaultOf([&] { RefuseSharedSurface(whole, first); }).find("shares the surface"),
            std::string::npos);
}

}  // namespace
}  // namespace hpdm
