#include "lcmtypes/analysis/slip_counter.h"

#include <gtest/gtest.h>

#include <vector>

namespace hpdm {
namespace {

/// Ticks of 1 ms in which the tissue slips by 1 um, or rests.
class Ticks {
 public:
  void Slip(int ticks) {
    for (int i = 0; i < ticks; ++i) Add(slip_ + 1e-6);
  }
  void Rest(int ticks) {
    for (int i = 0; i < ticks; ++i) Add(slip_);
  }
  void Release() { Add(0); }
  int count() const { return counter_.count(); }
  const std::vector<double>& begins() const { return begins_; }

 private:
  void Add(double slip) {
    slip_ = slip;
    if (counter_.Add(time_, slip)) begins_.push_back(time_);
    time_ += 1e-3;
  }
  SlipCounter counter_;
  double time_ = 0, slip_ = 0;
  std::vector<double> begins_;
};

TEST(SlipCounter, HeldTissueDoesNotSlip) {
  Ticks ticks;
  ticks.Rest(500);
  EXPECT_EQ(ticks.count(), 0);
  ticks.Slip(1);
  ticks.Rest(500);  // the way that it has slipped stays
  EXPECT_EQ(ticks.count(), 1);
}

TEST(SlipCounter, AShortRestBelongsToTheSlipAndALongOneEndsIt) {
  Ticks ticks;
  ticks.Slip(10);
  ticks.Rest(240);
  ticks.Slip(10);
  EXPECT_EQ(ticks.count(), 1) << "a rest of 0.24 s";
  ticks.Rest(260);
  ticks.Slip(10);
  EXPECT_EQ(ticks.count(), 2) << "a rest of 0.26 s";
}

TEST(SlipCounter, ASlipBeginsOnceAndInItsFirstTick) {
  Ticks ticks;
  ticks.Rest(100);
  ticks.Slip(400);
  ticks.Rest(300);
  ticks.Slip(1);
  ASSERT_EQ(ticks.begins().size(), 2u);
  EXPECT_NEAR(ticks.begins()[0], 0.1, 1e-9);
  EXPECT_NEAR(ticks.begins()[1], 0.8, 1e-9);
}

// The way begins at zero with every grasp: to let go is no slip, and a shorter way is one too.
TEST(SlipCounter, EachGraspCountsFromZero) {
  Ticks ticks;
  ticks.Slip(1000);
  ticks.Release();
  ticks.Rest(400);
  EXPECT_EQ(ticks.count(), 1);
  ticks.Slip(5);
  EXPECT_EQ(ticks.count(), 2);
}

}  // namespace
}  // namespace hpdm
