// The tick's force on viscoelastic tissue against the closed form of the generalised Maxwell law.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>
#include <vector>

#include "haptics/contact/haptic_contact.h"
#include "tests/support/contact_patches.h"
#include "tests/support/prony.h"

namespace hpdm {
namespace {

constexpr double kPeriod = 0.001;  // s
constexpr int kPatchTicks = 33;    // a new patch comes so often
constexpr double kDepth = 0.004;   // m

constexpr double kResolved = 0.02;  // m; a tip as wide makes no dent

// A plane patch of tissue at rest, 1.5 mm/N without the dent under a tip of `radius` (m).
ToolPatch TissuePatch(const PronySeries& prony, double radius, ContactKind kind) {
  ToolPatch patch = PlanePatch(7, 0.04, 0);
  patch.kind = kind;
  patch.reaction = ReactionType::kLattice;
  patch.prony = prony;
  const MaterialOptions material{.young = 5000, .poisson = 0.45};
  patch.indentation = radius < kResolved
                          ? LocalIndentation(material, Vector3d::UnitZ(), radius, kResolved)
                          : LocalIndentation(radius);
  patch.hold = 1e9;
  patch.compliance_W = 1.5e-3 * Matrix3d::Identity();
  for (int i = 0; i < patch.point_count; ++i) {
    PatchPoint& point = patch.points[static_cast<std::size_t>(i)];
    point.compliance_W = patch.compliance_W;
    point.tissue_W = point.p_original_W;
  }
  return patch;
}

// A hand on one patch that is renewed again and again, each time as the step would have left it
// without any contact: a held contact must not care.
class HeldTip {
 public:
  HeldTip(const PronySeries& prony, double radius, ContactKind kind = ContactKind::kPress,
          double friction = 0)
      : patch_(TissuePatch(prony, radius, kind)), radius_(radius), friction_(friction) {}

  // Returns the force on the hand (N) one tick later, with the tip's lowest point at `p_W`.
  Vector3d MoveTo(const Vector3d& p_W) {
    if (tick_ % kPatchTicks == 0) {
      patch_.time_ns = tick_ * 1'000'000;
      contact_.SetPatch(patch_);
    }
    const bool holds = patch_.kind == ContactKind::kGrasp;
    const Vector3d p_tip_W = holds ? p_W : Vector3d(p_W + radius_ * Vector3d::UnitZ());
    ++tick_;
    return contact_
        .Evaluate({.time_ns = tick_ * 1'000'000,
                   .X_WT = Isometry3d(Eigen::Translation3d(p_tip_W)),
                   .jaw = holds ? 0.0 : 1.0,
                   .tip_radius = radius_,
                   .friction = friction_})
        .reaction_W;
  }
  double Press(double depth) { return MoveTo({0.001, 0.002, -depth}).z(); }
  ToolPatch& patch() { return patch_; }

 private:
  ToolPatch patch_;
  double radius_, friction_;
  HapticContact contact_;
  Nanoseconds tick_ = 0;
};

const PronySeries kThreeTerms = Prony({{0.3, 0.02}, {0.2, 0.5}, {0.25, 20}});
constexpr double kLongTerm = 0.25;  // 1 - sum g

double Elastic(double radius, double depth) { return HeldTip({}, radius).Press(depth); }

// sum_k g_k (1 - exp(-t / tau_k))
double Relaxed(const PronySeries& prony, double t) {
  double sum = 0;
  for (int k = 0; k < prony.count; ++k) {
    const auto& [share, time] = prony.terms[static_cast<std::size_t>(k)];
    sum += share * (1 - std::exp(-t / time));
  }
  return sum;
}

TEST(ViscoelasticContact, AHeldPressRelaxesByTheLawUnderEveryTip) {
  for (const double radius : {0.001, 0.0025, 0.015}) {
    for (const double depth : {0.0004, kDepth}) {
      HeldTip hand(kThreeTerms, radius);
      // The first tick moves the tissue within a period, so it begins half a period earlier.
      for (int tick = 0; tick < 5000; ++tick) {
        const double force = hand.Press(depth);
        const double law =
            Elastic(radius, depth) / kLongTerm * (1 - Relaxed(kThreeTerms, (tick + 0.5) * kPeriod));
        ASSERT_NEAR(force, law, 2e-3 * law) << radius << ' ' << depth << ' ' << tick;
      }
    }
  }
}

// Two springs in series of which one relaxes.
TEST(ViscoelasticContact, TissueOnAnElasticSupportRelaxesByTheClosedForm) {
  constexpr double kSeries = 0.6e-3, kWhole = 1.5e-3;  // m/N
  const PronySeries prony = Prony({{0.75, 0.3}});
  constexpr double kRatio = 3, kTissue = kWhole - kSeries;
  for (const ContactKind kind : {ContactKind::kPress, ContactKind::kGrasp}) {
    HeldTip hand(prony, 0.03, kind);
    hand.patch().series_W = kSeries * Matrix3d::Identity();
    const double tau = 0.3 * (1 + kRatio * kSeries / kWhole);
    const double F_0 = kDepth / (kSeries + kTissue / (1 + kRatio)), F_inf = kDepth / kWhole;
    if (kind == ContactKind::kGrasp) hand.Press(0);
    for (int tick = 0; tick < 3000; ++tick) {
      const double law = F_inf + (F_0 - F_inf) * std::exp(-(tick + 0.5) * kPeriod / tau);
      ASSERT_NEAR(hand.Press(kDepth), law, 2e-3 * law) << tick;
    }
  }
}

TEST(ViscoelasticContact, ARampFollowsTheLawsIntegral) {
  constexpr double kSpeed = 0.01;  // m/s
  HeldTip hand(kThreeTerms, 0.0025, ContactKind::kGrasp);
  hand.MoveTo(Vector3d::Zero());
  const double stiffness = 1 / 1.5e-3;
  for (int tick = 1; tick < 2000; ++tick) {
    const double t = tick * kPeriod, ramp = std::min(t, 0.5);
    const double force = -hand.MoveTo({0, 0, kSpeed * ramp}).z();
    double law = stiffness * kSpeed * ramp;
    for (int k = 0; k < 3; ++k) {
      const auto& [share, time] = kThreeTerms.terms[static_cast<std::size_t>(k)];
      law += stiffness * kSpeed * share / kLongTerm * time *
             (std::exp(-(t - ramp) / time) - std::exp(-t / time));
    }
    // The fade at a patch's arrival takes curvature for a jump.
    ASSERT_NEAR(force, law, 3e-4 * law) << tick;
  }
}

// Returns the force's amplitude over that of elastic tissue and its phase ahead of the motion, as
// a complex number: the last two periods of `amplitude` (m) about `depth`.
std::complex<double> Response(HeldTip* hand, double frequency, double depth, double amplitude) {
  const double omega = 2 * std::numbers::pi * frequency;
  const int period = static_cast<int>(std::lround(1 / (frequency * kPeriod)));
  // The slow terms have relaxed to their mean after this.
  const int before = (static_cast<int>(20 / kPeriod) / period + 1) * period;
  for (int tick = 0; tick < before; ++tick)
    hand->Press(depth + amplitude * std::sin(omega * tick * kPeriod));
  std::complex<double> sum = 0;
  for (int tick = before; tick < before + 2 * period; ++tick) {
    const double t = tick * kPeriod;
    sum += hand->Press(depth + amplitude * std::sin(omega * t)) *
           std::exp(std::complex<double>(0, -omega * t));
  }
  return sum / (period * amplitude) * std::complex<double>(0, 1);
}

TEST(ViscoelasticContact, ASineHasTheComplexModulusOfTheLaw) {
  for (const double radius : {0.0025, 0.015}) {
    for (const double frequency : {0.1, 1.0, 10.0}) {
      constexpr double kAmplitude = 2e-5;
      const PronySeries prony = Prony({{0.3, 0.02}, {0.2, 0.3}, {0.25, 2}});
      HeldTip hand(prony, radius);
      const std::complex<double> felt = Response(&hand, frequency, kDepth, kAmplitude);
      const double slope =
          (Elastic(radius, kDepth + kAmplitude) - Elastic(radius, kDepth - kAmplitude)) /
          (2 * kAmplitude);
      std::complex<double> law = 1;
      for (int k = 0; k < 3; ++k) {
        const auto& [share, time] = prony.terms[static_cast<std::size_t>(k)];
        const std::complex<double> i_w_tau(0, 2 * std::numbers::pi * frequency * time);
        law += share / kLongTerm * i_w_tau / (1.0 + i_w_tau);
      }
      EXPECT_NEAR(std::abs(felt) / (slope * std::abs(law)), 1, 0.02) << radius << ' ' << frequency;
      EXPECT_NEAR(std::arg(felt) - std::arg(law), 0, 2 * std::numbers::pi / 180)
          << radius << ' ' << frequency;
    }
  }
}

TEST(ViscoelasticContact, TissueThatWasPressedForLongLagsBehindTheTip) {
  const PronySeries prony = Prony({{0.5, 0.2}});
  HeldTip hand(prony, kResolved);
  for (int tick = 0; tick < 2000; ++tick) hand.Press(kDepth);
  // Half of the depth returns at once; above that the tip is free.
  EXPECT_EQ(hand.Press(0.3 * kDepth), 0);
  EXPECT_EQ(hand.Press(0.45 * kDepth), 0);
  EXPECT_GT(hand.Press(0.6 * kDepth), 0);
  // It returns as exp(-t (1 - g) / tau).
  for (int tick = 0; tick < 100; ++tick) EXPECT_EQ(hand.Press(0.1 * kDepth), 0);
  EXPECT_EQ(hand.Press(0.35 * kDepth), 0);
  EXPECT_GT(hand.Press(0.45 * kDepth), 0);
}

TEST(ViscoelasticContact, ATipThatSlidesOnMeetsFreshTissue) {
  const PronySeries prony = Prony({{0.6, 2}});
  for (const double radius : {0.0025, 0.008}) {
    HeldTip hand(prony, radius);
    const double elastic = Elastic(radius, kDepth);
    Vector3d p(-0.03, 0.002, -kDepth);
    double force = 0;
    for (int tick = 0; tick < 10'000; ++tick) force = hand.MoveTo(p).z();
    EXPECT_NEAR(force / elastic, 1, 0.02);
    // The patch's tissue stays at rest, so ahead all is fresh.
    for (int tick = 0; tick < 600; ++tick) {
      p.x() += 1e-4;
      force = hand.MoveTo(p).z();
    }
    EXPECT_GT(force / elastic, 0.9 / 0.4) << radius;
  }
}

TEST(ViscoelasticContact, ATipTakesTheMemoryOfThePatchWhereItBegins) {
  const PronySeries prony = Prony({{0.5, 1e3}});
  HeldTip hand(prony, kResolved);
  for (int i = 0; i < hand.patch().point_count; ++i) {
    PatchPoint& point = hand.patch().points[static_cast<std::size_t>(i)];
    // Relaxed tissue that has just been let go: half of 2 mm is left.
    point.tissue_W.z() = -0.001;
    point.branches_W[0].z() = 0.001;
  }
  EXPECT_EQ(hand.Press(0.0009), 0);
  const double instantaneous = Elastic(kResolved, 0.002) / 0.5;
  EXPECT_NEAR(hand.Press(0.002), instantaneous / 2, 1e-3 * instantaneous);
}

TEST(ViscoelasticContact, AGraspBeginsWithTheStepsMemoryAndRelaxes) {
  HeldTip hand(kThreeTerms, 0.0025, ContactKind::kGrasp);
  ToolPatch& patch = hand.patch();
  // Lifted by 5 mm long ago: the fast terms have relaxed, half of the slowest is left.
  patch.contact_W = Vector3d(0, 0, 0.005);
  patch.branches_W[2] = Vector3d(0, 0, 0.0025);
  patch.p_grasp_T = Vector3d::Zero();
  const double relaxed = 0.005 / 1.5e-3;
  for (int tick = 0; tick < 3000; ++tick) {
    const double force = -hand.MoveTo({0, 0, 0.005}).z();
    const double law =
        relaxed + 0.25 / kLongTerm * 0.0025 / 1.5e-3 * std::exp(-(tick + 1) * kPeriod / 20);
    ASSERT_NEAR(force, law, 1e-6 * law);
  }
}

// Random motion along the normal, or in a grasp: a contact that never slides is made of springs and
// dampers.
TEST(ViscoelasticContact, AContactThatIsHeldNeverGivesMoreThanItStores) {
  for (const double time : {0.003, 0.1, 10.0}) {
    for (const ContactKind kind : {ContactKind::kPress, ContactKind::kGrasp}) {
      HeldTip hand(Prony({{0.45, time}, {0.45, 3 * time}}), 0.0025, kind);
      std::mt19937 random(7);
      std::uniform_real_distribution<double> toss(-1, 1);
      Vector3d target(0.001, 0.002, 0), p = target, last_W = Vector3d::Zero();
      hand.patch().contact_W = hand.patch().p_original_W = p;
      double work = 0, largest = 0;  // J, by the hand
      for (int tick = 0; tick < 10'000; ++tick) {
        if (tick % 50 == 0) {
          target = Vector3d(0.001, 0.002, -0.003 + 0.004 * toss(random));
          if (kind == ContactKind::kGrasp) target.x() += 0.004 * toss(random);
        }
        const Vector3d way = 0.05 * (target - p);
        p += way;
        const Vector3d force_W = hand.MoveTo(p);
        work -= 0.5 * (force_W + last_W).dot(way);
        last_W = force_W;
        largest = std::max(largest, work);
        // The trapezoid's error in a tick is second order.
        ASSERT_GT(work, -1e-3 * std::max(largest, 1e-4)) << time << ' ' << tick;
      }
      EXPECT_GT(work, 1e-3) << "dissipated";
    }
  }
}

}  // namespace
}  // namespace hpdm
