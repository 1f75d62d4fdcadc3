#include "engine/pairs/organ_pair.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>

#include "tests/support/counted_allocations.h"
#include "tests/support/posed_surface.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr double kPi = std::numbers::pi;

Isometry3d MovedBy(const Vector3d& way) { return Isometry3d(Eigen::Translation3d(way)); }

Isometry3d RandomPose(std::mt19937* random) {
  std::normal_distribution<double> normal;
  Isometry3d X = Isometry3d::Identity();
  const Eigen::Quaterniond q(normal(*random), normal(*random), normal(*random), normal(*random));
  X.linear() = q.normalized().toRotationMatrix();
  X.translation() = 0.1 * Vector3d(normal(*random), normal(*random), normal(*random));
  return X;
}

double SumOfWeights(const PairContact& contact) {
  double sum = 0;
  for (const PairSample& sample : contact.samples) sum += sample.weight;
  return sum;
}

double TotalArea(std::span<const PairContact> contacts) {
  double sum = 0;
  for (const PairContact& contact : contacts) sum += contact.area;
  return sum;
}

double LeastGap(std::span<const PairContact> contacts) {
  double least = 1;
  for (const PairContact& contact : contacts) least = std::min(least, contact.least_gap);
  return least;
}

/// Two spheres on a line of any direction, of several sizes and meshes.
struct SphereCase {
  double radius_a, radius_b;
  int splits_a, splits_b;
  double gap;  // m
};

class PairOfSpheres : public testing::TestWithParam<SphereCase> {};

TEST_P(PairOfSpheres, HasTheGapsNormalsAndAreaOfTheClosedForm) {
  const SphereCase& c = GetParam();
  std::mt19937 random(3);
  for (int trial = 0; trial < 3; ++trial) {
    const Vector3d p_a = RandomPose(&random).translation();
    const Vector3d axis = RandomPose(&random).linear().col(0);
    const double distance = c.radius_a + c.radius_b + c.gap;
    const Vector3d p_b = p_a + distance * axis;
    PosedSurface a(Ellipsoid(Vector3d::Constant(c.radius_a), c.splits_a));
    PosedSurface b(Ellipsoid(Vector3d::Constant(c.radius_b), c.splits_b));
    a.Place(MovedBy(p_a));
    b.Place(MovedBy(p_b));
    // The facets' greatest distance from the sphere: edges of 1.11 R / 2^splits.
    const auto facet = [](double radius, int splits) {
      return std::pow(1.11 * radius / std::exp2(splits), 2) / (6 * radius);
    };
    const double error = facet(c.radius_a, c.splits_a) + facet(c.radius_b, c.splits_b);
    ASSERT_LT(error, 0.0003);

    OrganPair pair(a.surface(), b.surface());
    pair.Update(a.shape(), b.shape());  // from the rest place: a large margin
    const auto contacts = pair.Update(a.shape(), b.shape());
    ASSERT_GT(contacts.size(), 0);
    EXPECT_TRUE(pair.complete());
    const bool a_is_finer =
        c.radius_a * std::exp2(-c.splits_a) <= c.radius_b * std::exp2(-c.splits_b);
    ASSERT_EQ(contacts[0].key % 2, a_is_finer ? 0 : 1);
    for (const PairContact& contact : contacts) {
      EXPECT_NEAR(SumOfWeights(contact), 1, 1e-12);
      Vector3d x_a = Vector3d::Zero(), x_b = x_a, normal = x_a, exact = x_a;
      for (const PairSample& sample : contact.samples) {
        const Vector3d on_a = a.At(sample.on_a), on_b = b.At(sample.on_b);
        x_a += sample.weight * on_a;
        x_b += sample.weight * on_b;
        normal += sample.weight * ((on_a - p_a).normalized() - (on_b - p_b).normalized());
        // The closest point of one sphere to a point of the other.
        exact += sample.weight *
                 (a_is_finer ? Vector3d(p_b + c.radius_b * (on_a - p_b).normalized() - on_a)
                             : Vector3d(on_b - p_a - c.radius_a * (on_b - p_a).normalized()));
      }
      EXPECT_NEAR(contact.gap, contact.normal_W.dot(x_b - x_a), 1e-12);
      normal.normalize();
      EXPECT_LT((contact.normal_W - normal).norm(), 0.03);
      EXPECT_NEAR(contact.gap, normal.dot(exact), 1.5 * error + 2e-5);
    }
    // Some sample lies within 1.5 mm of the axis, where the gap is least.
    const double effective = 1 / (1 / c.radius_a + 1 / c.radius_b);
    EXPECT_NEAR(LeastGap(contacts), c.gap, error + 0.0015 * 0.0015 / (2 * effective));
    // The cap of one sphere within the other, grown by each distance below kTouching.
    const double carrier = a_is_finer ? c.radius_a : c.radius_b;
    const double other = c.radius_a + c.radius_b - carrier;
    double area = 0;
    for (int i = 0; i < 100; ++i) {
      const double grown = other + OrganPair::kTouching * (i + 0.5) / 100;
      const double cosine =
          (carrier * carrier + distance * distance - grown * grown) / (2 * carrier * distance);
      if (cosine < 1) area += 2 * kPi * carrier * carrier * (1 - cosine) / 100;
    }
    EXPECT_NEAR(TotalArea(contacts), area, 0.1 * area + 2 * kPi * effective * error + 4e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, PairOfSpheres,
    testing::Values(SphereCase{0.05, 0.05, 4, 4, 0.001}, SphereCase{0.05, 0.05, 4, 4, -0.0005},
                    SphereCase{0.02, 0.06, 4, 5, -0.0005}, SphereCase{0.02, 0.06, 4, 5, 0.0003},
                    SphereCase{0.03, 0.03, 3, 4, -0.002}, SphereCase{0.08, 0.04, 5, 5, -0.001}));

/// A block of 40 x 40 x 20 mm over a plate of 70 x 70 x `thickness`, with its top at z = 0.
struct Stack {
  explicit Stack(double thickness = 0.02)
      : block(GridBox(Vector3d(-0.02, -0.02, 0), Vector3d(0.02, 0.02, 0.02), {10, 10, 5})),
        plate(GridBox(Vector3d(-0.035, -0.035, -thickness), Vector3d(0.035, 0.035, 0), {9, 9, 2})) {
  }
  void Lower(double gap) { block.Place(MovedBy(Vector3d(0, 0, gap))); }
  PosedSurface block, plate;
};

TEST(OrganPair, BlocksFaceToFaceHaveOneGapAndTheFacesArea) {
  for (const double gap : {0.001, 0.0, -0.0004, -0.003}) {
    Stack stack;
    stack.Lower(gap);
    OrganPair pair(stack.block.surface(), stack.plate.surface());
    const auto contacts = pair.Update(stack.block.shape(), stack.plate.shape());
    ASSERT_GT(contacts.size(), 10);
    for (const PairContact& contact : contacts) {
      EXPECT_NEAR(contact.gap, gap, 1e-12);
      EXPECT_NEAR(contact.least_gap, gap, 1e-12);
      EXPECT_LT((contact.normal_W + Vector3d::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(SumOfWeights(contact), 1, 1e-12);
    }
    if (gap <= 0) {
      EXPECT_NEAR(TotalArea(contacts), 0.04 * 0.04, 1e-12);
    }
    EXPECT_TRUE(pair.complete());
  }
}

// The mean over a contact's samples by their weights is that of the face, so equal pressures on all
// samples leave no moment.
TEST(OrganPair, SamplesOfAFaceBalanceAboutItsMiddle) {
  Stack stack;
  stack.Lower(-0.0002);
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  Vector3d moment = Vector3d::Zero();
  double area = 0;
  for (const PairContact& contact : pair.Update(stack.block.shape(), stack.plate.shape())) {
    for (const PairSample& sample : contact.samples) {
      moment += contact.area * sample.weight * stack.block.At(sample.on_a);
      EXPECT_LT((stack.block.At(sample.on_a) - stack.plate.At(sample.on_b)).head(2).norm(), 1e-9);
    }
    area += contact.area;
  }
  EXPECT_LT((moment / area).head(2).norm(), 1e-9);
}

TEST(OrganPair, SwappedOrgansHaveTheSameContactsTheOtherWayRound) {
  PosedSurface a(Ellipsoid(Vector3d(0.05, 0.04, 0.03), 4)),
      b(Ellipsoid(Vector3d(0.06, 0.06, 0.03), 3));
  b.Place(MovedBy(Vector3d(0.004, 0.003, 0.0592)));
  b.offset_W = Vector3d(0.001, -0.002, 0.0003);
  OrganPair pair(a.surface(), b.surface()), swapped(b.surface(), a.surface());
  const auto contacts = pair.Update(a.shape(), b.shape());
  const auto other = swapped.Update(b.shape(), a.shape());
  ASSERT_EQ(contacts.size(), other.size());
  ASSERT_GT(contacts.size(), 3);
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    EXPECT_EQ(contacts[c].key / 2, other[c].key / 2);
    EXPECT_NE(contacts[c].key, other[c].key);
    EXPECT_EQ(contacts[c].normal_W, -other[c].normal_W);
    EXPECT_EQ(contacts[c].gap, other[c].gap);
    EXPECT_EQ(contacts[c].area, other[c].area);
    ASSERT_EQ(contacts[c].samples.size(), other[c].samples.size());
    for (std::size_t s = 0; s < other[c].samples.size(); ++s) {
      EXPECT_EQ(contacts[c].samples[s].on_a.triangle, other[c].samples[s].on_b.triangle);
      EXPECT_EQ(contacts[c].samples[s].weight, other[c].samples[s].weight);
    }
  }
}

TEST(OrganPair, MovesWithBothOrgans) {
  std::mt19937 random(5);
  PosedSurface a(Ellipsoid(Vector3d(0.05, 0.04, 0.03), 4)),
      b(Ellipsoid(Vector3d(0.06, 0.06, 0.03), 3));
  const Isometry3d X_ab = MovedBy(Vector3d(0.004, 0.003, 0.0588));
  b.Place(X_ab);
  OrganPair still(a.surface(), b.surface());
  still.Update(a.shape(), b.shape());  // from the rest place: a large margin
  const auto expected = still.Update(a.shape(), b.shape());
  ASSERT_GT(expected.size(), 3);
  for (int trial = 0; trial < 10; ++trial) {
    const Isometry3d X = RandomPose(&random);
    a.Place(X);
    b.Place(X * X_ab);
    // The same place by the organs' offsets.
    const Vector3d way(0.02, -0.01, 0.03);
    b.Place(MovedBy(-way) * X * X_ab);
    b.offset_W = way;
    OrganPair pair(a.surface(), b.surface());
    pair.Update(a.shape(), b.shape());
    const auto contacts = pair.Update(a.shape(), b.shape());
    ASSERT_EQ(contacts.size(), expected.size());
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      EXPECT_EQ(contacts[c].key, expected[c].key);
      EXPECT_NEAR(contacts[c].gap, expected[c].gap, 1e-10);
      EXPECT_LT((contacts[c].normal_W - X.linear() * expected[c].normal_W).norm(), 1e-8);
    }
  }
}

// The block is driven through a plate of 3 mm and back.
TEST(OrganPair, AWallIsLeftOnTheSideOnWhichItWasEntered) {
  Stack stack(0.003);
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  for (int step = 0; step <= 40; ++step) {
    const double gap = step <= 20 ? 0.001 - 0.0004 * step : -0.007 + 0.0004 * (step - 20);
    stack.Lower(gap);
    const auto contacts = pair.Update(stack.block.shape(), stack.plate.shape());
    ASSERT_GT(contacts.size(), 10) << gap;
    for (const PairContact& contact : contacts) {
      EXPECT_NEAR(contact.gap, gap, 1e-12);
      EXPECT_LT((contact.normal_W + Vector3d::UnitZ()).norm(), 1e-12);
    }
  }
}

TEST(OrganPair, AJumpIntoAWallBeyondItsMiddleIsPushedBackByTheFaceThatItPassed) {
  Stack stack(0.003);
  stack.Lower(-0.0025);
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  const auto contacts = pair.Update(stack.block.shape(), stack.plate.shape());
  ASSERT_GT(contacts.size(), 10);
  for (const PairContact& contact : contacts) {
    EXPECT_NEAR(contact.gap, -0.0025, 1e-12);
    EXPECT_LT((contact.normal_W + Vector3d::UnitZ()).norm(), 1e-12);
  }
}

TEST(OrganPair, ADeepJumpIsFoundAllOver) {
  Stack stack;
  stack.Lower(-0.013);
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  pair.Update(stack.block.shape(), stack.plate.shape());
  EXPECT_NEAR(TotalArea(pair.contacts()), 0.04 * 0.04, 1e-12);
}

TEST(OrganPair, OrgansApartHaveNoContacts) {
  Stack stack;
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  stack.Lower(0.1);
  pair.Update(stack.block.shape(), stack.plate.shape());
  stack.Lower(0.00201);
  EXPECT_GT(pair.Update(stack.block.shape(), stack.plate.shape()).size(), 0);  // it moved fast
  EXPECT_EQ(pair.Update(stack.block.shape(), stack.plate.shape()).size(), 0);
}

TEST(OrganPair, AToolsGrowingDemandWidensTheMarginAtOnce) {
  Stack stack;
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  stack.Lower(0.006);
  const PairShape free = stack.block.shape(), plate = stack.plate.shape();
  PairShape pressed = free;
  pressed.demand = 0.005;
  pair.Update(free, plate);
  EXPECT_EQ(pair.Update(free, plate).size(), 0);
  EXPECT_GT(pair.Update(pressed, plate).size(), 0);
  EXPECT_EQ(pair.Update(pressed, plate).size(), 0);  // a held press: it moves nothing
}

// Slides along a wavy surface, 0.02 mm a step: gaps change by no more than the surfaces' slopes and
// the weights allow, normals by no more than the curvature does.
TEST(OrganPair, GapsAndNormalsFollowASlowSlide) {
  for (const double depth : {0.0005, 0.002}) {
    PosedSurface ball(Ellipsoid(Vector3d::Constant(0.03), 4));
    PosedSurface ground(
        GridBox(Vector3d(-0.06, -0.06, -0.02), Vector3d(0.06, 0.06, 0), {30, 30, 5}));
    ground.Deform([](const Vector3d& p) {
      return Vector3d(p.x(), p.y(), p.z() + 0.002 * std::sin(80 * p.x()) * std::cos(70 * p.y()));
    });
    OrganPair pair(ball.surface(), ground.surface());
    constexpr double kStep = 2e-5;
    const Vector3d direction = Vector3d(1, 0.4, 0).normalized();
    std::map<std::uint64_t, PairContact> last;
    int common = 0;
    for (int step = 0; step < 1000; ++step) {
      ball.Place(MovedBy((step - 500) * kStep * direction + Vector3d(0, 0, 0.03 - depth)));
      std::map<std::uint64_t, PairContact> now;
      for (const PairContact& contact : pair.Update(ball.shape(), ground.shape())) {
        now[contact.key] = contact;
        const auto before = last.find(contact.key);
        if (step <= 1) continue;  // from the rest place: a large margin
        if (before == last.end()) {
          EXPECT_GT(contact.gap, 0.001) << step;  // a new contact is no firm one
          continue;
        }
        ++common;
        EXPECT_LT(std::abs(contact.gap - before->second.gap), kStep) << step;
        EXPECT_LT((contact.normal_W - before->second.normal_W).norm(), 0.01) << step;
        EXPECT_LT(std::abs(contact.area - before->second.area), 3e-6) << step;
      }
      if (step > 1) {
        for (const auto& [key, contact] : last) {
          EXPECT_TRUE(now.contains(key) || contact.gap > 0.001) << step;
        }
      }
      last = now;
    }
    EXPECT_GT(common, 3000);
  }
}

// A face with more cells than there are contacts: cells far from touching are gathered.
TEST(OrganPair, ALargeFaceKeepsAllItsSamplesInFewerContacts) {
  PosedSurface a(GridBox(Vector3d(-0.04, -0.04, 0), Vector3d(0.04, 0.04, 0.02), {20, 20, 5}));
  PosedSurface b(GridBox(Vector3d(-0.06, -0.06, -0.02), Vector3d(0.06, 0.06, 0), {10, 10, 2}));
  OrganPair pair(a.surface(), b.surface());
  std::vector<std::uint64_t> keys[2];
  for (int step = 0; step < 20; ++step) {
    Isometry3d X = MovedBy(Vector3d(0, 0, -0.0005));
    // Tilted by 0.3 mm over its width, and by a hundredth of that to and fro.
    X.rotate(Eigen::AngleAxisd(4e-3 + 4e-5 * std::sin(1.0 * step), Vector3d::UnitX()));
    a.Place(X);
    const auto contacts = pair.Update(a.shape(), b.shape());
    EXPECT_TRUE(pair.complete());
    EXPECT_LE(contacts.size(), OrganPair::kMaxPatches);
    EXPECT_GT(contacts.size(), OrganPair::kMaxPatches / 2);
    EXPECT_NEAR(TotalArea(contacts), 0.08 * 0.08, 1e-7);
    const PairContact* deepest = &contacts[0];
    const PairContact* highest = &contacts[0];
    auto& now = keys[step > 0];
    now.clear();
    for (const PairContact& contact : contacts) {
      EXPECT_NEAR(SumOfWeights(contact), 1, 1e-12);
      EXPECT_LT((contact.normal_W + Vector3d::UnitZ()).norm(), 0.01);
      if (contact.least_gap < deepest->least_gap) deepest = &contact;
      if (contact.least_gap > highest->least_gap) highest = &contact;
      now.push_back(contact.key);
    }
    if (step == 0) keys[1] = keys[0];
    EXPECT_EQ(keys[1], keys[0]) << step;
    // The deepest place keeps a row of its own.
    EXPECT_LT(deepest->area, 1.5e-4);
    EXPECT_GT(highest->area, 1.5e-4);
  }
}

// A face on a face that needs more contacts even so.
TEST(OrganPair, KeepsTheSameRowsWhenThereAreTooMany) {
  PosedSurface a(GridBox(Vector3d(-0.08, -0.08, 0), Vector3d(0.08, 0.08, 0.02), {40, 40, 5}));
  PosedSurface b(GridBox(Vector3d(-0.09, -0.09, -0.02), Vector3d(0.09, 0.09, 0), {10, 10, 2}));
  OrganPair pair(a.surface(), b.surface());
  std::mt19937 random(7);
  std::vector<std::uint64_t> first;
  for (int step = 0; step < 20; ++step) {
    Isometry3d X = MovedBy(Vector3d(0, 0, -0.0005));
    X.rotate(Eigen::AngleAxisd(2e-4 * std::sin(1.0 * step),
                               Vector3d(1, std::cos(1.0 * step), 0).normalized()));
    a.Place(X);
    std::vector<std::uint64_t> keys;
    for (const PairContact& contact : pair.Update(a.shape(), b.shape()))
      keys.push_back(contact.key);
    EXPECT_EQ(keys.size(), OrganPair::kMaxPatches);
    EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
    EXPECT_FALSE(pair.complete());
    if (step == 0) first = keys;
    EXPECT_EQ(keys, first) << step;
  }
}

TEST(OrganPair, OrgansHaveTheContactsOfTheirSurfaces) {
  OrganOptions options;
  options.name = "body";
  options.model = OrganModelType::kRigid;
  Isometry3d X = MovedBy(Vector3d(0.004, 0.003, 0.0588));
  const SurfaceMesh low = Ellipsoid(Vector3d(0.05, 0.04, 0.03), 4);
  const SurfaceMesh high = Ellipsoid(Vector3d(0.06, 0.06, 0.03), 3, X);
  const OrganModel model_a(options, low), model_b(options, high);
  OrganState a(model_a, 1), b(model_b, 1);
  b.offset_W = Vector3d(0, 0, 2e-4);
  PosedSurface surface_a(low), surface_b(high);
  surface_b.offset_W = b.offset_W;
  OrganPair organs(model_a, model_b), surfaces(surface_a.surface(), surface_b.surface());
  const auto found = organs.Update(a, b);
  const auto expected = surfaces.Update(surface_a.shape(), surface_b.shape());
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_GT(found.size(), 3);
  for (std::size_t c = 0; c < found.size(); ++c) {
    EXPECT_EQ(found[c].key, expected[c].key);
    EXPECT_EQ(found[c].gap, expected[c].gap);
  }
}

TEST(OrganPair, AStepAllocatesNothing) {
  if (!kCountsAllocations) GTEST_SKIP();
  Stack stack;
  OrganPair pair(stack.block.surface(), stack.plate.surface());
  const long before = AllocationsOfThisThread();
  std::size_t found = 0;
  for (int step = 0; step < 40; ++step) {
    stack.Lower(0.004 - 0.0005 * step);
    found += pair.Update(stack.block.shape(), stack.plate.shape()).size();
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
  EXPECT_GT(found, 100);
}

using FclModel = fcl::BVHModel<fcl::OBBRSS<double>>;

std::shared_ptr<FclModel> ModelOf(const PosedSurface& surface) {
  std::vector<Vector3d> points;
  std::vector<fcl::Triangle> faces;
  for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
    points.emplace_back(surface.vertices.row(v));
  for (Eigen::Index t = 0; t < surface.rest().triangles.rows(); ++t) {
    const auto row = surface.rest().triangles.row(t);
    faces.emplace_back(row[0], row[1], row[2]);
  }
  auto model = std::make_shared<FclModel>();
  model->beginModel();
  model->addSubModel(points, faces);
  model->endModel();
  return model;
}

TEST(OrganPair, AgreesWithTheDistanceAndTheCollisionOfFcl) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> gap(-0.002, 0.0018);
  int apart = 0, touching = 0;
  for (int trial = 0; trial < 24; ++trial) {
    PosedSurface a(Ellipsoid(Vector3d(0.05, 0.04, 0.03), 3));
    PosedSurface b(Ellipsoid(Vector3d(0.06, 0.045, 0.04), 3));
    const auto deform = [&](PosedSurface* surface) {
      const Vector3d k = 60 * RandomPose(&random).linear().col(0);
      const Vector3d along = 0.003 * RandomPose(&random).linear().col(0);
      surface->Place(Isometry3d(RandomPose(&random).linear()));
      surface->Deform([&](const Vector3d& p) { return Vector3d(p + std::sin(k.dot(p)) * along); });
    };
    deform(&a);
    deform(&b);
    const auto model_a = ModelOf(a), model_b = ModelOf(b);
    const auto distance = [&](const Vector3d& way) {
      fcl::DistanceRequest<double> request(true);
      fcl::DistanceResult<double> result;
      fcl::distance<double>(model_a.get(), Isometry3d::Identity(), model_b.get(), MovedBy(way),
                            request, result);
      return result.min_distance;
    };
    double z = 0.12;  // towards a along z until they nearly touch
    for (int i = 0; i < 12; ++i) z -= std::max(0.0, distance(Vector3d(0, 0, z)) - 1e-5);
    b.offset_W = Vector3d(0, 0, z + gap(random));
    OrganPair pair(a.surface(), b.surface());
    pair.Update(a.shape(), b.shape());
    const auto contacts = pair.Update(a.shape(), b.shape());
    fcl::CollisionRequest<double> request(1);
    fcl::CollisionResult<double> result;
    fcl::collide<double>(model_a.get(), Isometry3d::Identity(), model_b.get(), MovedBy(b.offset_W),
                         request, result);
    if (result.isCollision()) {
      ++touching;
      ASSERT_GT(contacts.size(), 0);
      EXPECT_LT(LeastGap(contacts), 5e-5);
      continue;
    }
    const double exact = distance(b.offset_W);
    if (exact > 0.0019) continue;
    ++apart;
    ASSERT_GT(contacts.size(), 0) << exact;
    EXPECT_NEAR(LeastGap(contacts), exact, 1.5e-4) << trial;
  }
  EXPECT_GT(apart, 5);
  EXPECT_GT(touching, 5);
}

}  // namespace
}  // namespace hpdm
