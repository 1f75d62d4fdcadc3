#include "tools/session/teacher_desk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace hpdm {
namespace {

constexpr Nanoseconds kSecond = kNanosecondsPerSecond;

class TeacherDeskTest : public testing::Test {
 protected:
  void Ask(TeacherRequest::Kind kind, double x = 0.5, double y = 0.5,
           const std::string& text = "") {
    TeacherRequest request{.kind = kind, .x = x, .y = y};
    std::ranges::copy(text, request.text.begin());
    requests_.Push(request);
  }
  std::vector<std::string> Events() {
    std::vector<std::string> names;
    for (LoopEvent event; events_.Pop(&event);) {
      names.emplace_back(event.name.data());
      text_ = event.text.data();
    }
    return names;
  }
  int Shown() {
    marks_.Update();
    return marks_.Front().count;
  }

  SpscQueue<TeacherRequest> requests_{16};
  TripleBuffer<PictureMarks> marks_;
  SpscQueue<LoopEvent> events_{16};
  TeacherDesk desk_{{requests_, marks_, events_}};
  std::string text_;  // of the last event
};

using Names = std::vector<std::string>;

TEST_F(TeacherDeskTest, TheLastPauseOrContinueCountsAndEachIsLogged) {
  EXPECT_FALSE(desk_.Handle(0, 0).pause.has_value());
  Ask(TeacherRequest::Kind::kPause);
  EXPECT_EQ(desk_.Handle(0, 0).pause, true);
  EXPECT_FALSE(desk_.Handle(0, 0).pause.has_value()) << "once";
  Ask(TeacherRequest::Kind::kPause);
  Ask(TeacherRequest::Kind::kContinue);
  EXPECT_EQ(desk_.Handle(0, 0).pause, false);
  EXPECT_EQ(Events(), (Names{"teacher.paused", "teacher.paused", "teacher.continued"}));
  EXPECT_FALSE(marks_.Update()) << "no marks";
}

TEST_F(TeacherDeskTest, ARestartIsHandedOnAndLoggedAsPeopleCount) {
  EXPECT_FALSE(desk_.Handle(0, 0).restart_step.has_value());
  requests_.Push({.kind = TeacherRequest::Kind::kRestart, .step = 4});
  EXPECT_EQ(desk_.Handle(0, 0).restart_step, 4);
  EXPECT_FALSE(desk_.Handle(0, 0).restart_step.has_value()) << "once";
  EXPECT_EQ(Events(), Names{"teacher.restart"});
  EXPECT_EQ(text_, "the teacher restarts the exercise at step 5");
  Ask(TeacherRequest::Kind::kRestart);
  EXPECT_EQ(desk_.Handle(0, 0).restart_step, RestartRequest::kPresent);
  EXPECT_EQ(Events(), Names{"teacher.restart"});
  EXPECT_EQ(text_, "the teacher restarts the exercise at its present step");
}

TEST_F(TeacherDeskTest, APointIsShownForItsTime) {
  Ask(TeacherRequest::Kind::kPoint, 0.25, 0.75, "the duct");
  desk_.Handle(2 * kSecond, 0);
  ASSERT_EQ(Shown(), 1);
  const PictureMark& mark = marks_.Front().marks[0];
  EXPECT_EQ(mark.kind, PictureMark::Kind::kPoint);
  EXPECT_EQ(mark.x, 0.25);
  EXPECT_EQ(mark.y, 0.75);
  EXPECT_STREQ(mark.text.data(), "the duct");
  EXPECT_EQ(Events(), Names{"teacher.point"});
  EXPECT_EQ(
      text_,
      "the teacher points at 25 % from the left and 75 % from the top of the picture: the duct");
  desk_.Handle(2 * kSecond + TeacherDesk::kPointShown - 1, 0);
  EXPECT_EQ(Shown(), 1);
  desk_.Handle(2 * kSecond + TeacherDesk::kPointShown, 0);
  EXPECT_EQ(Shown(), 0);
}

TEST_F(TeacherDeskTest, EachBleedingThatIsOverTakesTheOldestMarkAway) {
  Ask(TeacherRequest::Kind::kBleed, 0.1);
  Ask(TeacherRequest::Kind::kPoint, 0.2);
  Ask(TeacherRequest::Kind::kBleed, 0.3);
  desk_.Handle(0, 0);
  EXPECT_EQ(Events(), (Names{"teacher.bleeding", "teacher.point", "teacher.bleeding"}));
  EXPECT_EQ(Shown(), 3);
  desk_.Handle(100 * kSecond, 0);
  EXPECT_EQ(Shown(), 2) << "bleedings stay, the point does not";
  desk_.Handle(101 * kSecond, 1);
  ASSERT_EQ(Shown(), 1);
  EXPECT_EQ(marks_.Front().marks[0].x, 0.3);
  desk_.Handle(102 * kSecond, 2);
  EXPECT_EQ(Shown(), 0);
}

TEST_F(TeacherDeskTest, MoreMarksThanFitReplaceTheOldestPoint) {
  Ask(TeacherRequest::Kind::kBleed, 0.9);
  for (int i = 0; i < PictureMarks::kMost; ++i) Ask(TeacherRequest::Kind::kPoint, 0.1 * i);
  desk_.Handle(0, 0);
  ASSERT_EQ(Shown(), PictureMarks::kMost);
  EXPECT_EQ(marks_.Front().marks[0].kind, PictureMark::Kind::kBleeding);
  EXPECT_EQ(marks_.Front().marks[1].x, 0.1) << "the first point, at 0, is gone";
}

}  // namespace
}  // namespace hpdm
