#include "lcmtypes/live/teacher_link.h"

#include <gtest/gtest.h>

#include <chrono>
#include <lcm/lcm-cpp.hpp>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

std::vector<std::uint8_t> RequestBytes(int request, double x, double y, const std::string& text,
                                       int step = 0) {
  teacher_t message{};
  message.request = static_cast<std::int8_t>(request);
  message.x = x;
  message.y = y;
  message.text = text;
  message.step = step;
  std::vector<std::uint8_t> bytes;
  EncodeMessage(message, &bytes);
  return bytes;
}

TEST(TeacherLink, ReadsEachRequest) {
  TeacherRequest request;
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::POINT, 0, 1, "here"), &request));
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kPoint);
  EXPECT_EQ(request.x, 0);
  EXPECT_EQ(request.y, 1);
  EXPECT_STREQ(request.text.data(), "here");
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::BLEED, 0.5, 0.5, ""), &request));
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kBleed);
  EXPECT_STREQ(request.text.data(), "") << "nothing is left of the request before";
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::PAUSE, 7, 7, ""), &request)) << "without a place";
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kPause);
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::CONTINUE, 0, 0, ""), &request));
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kContinue);
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::RESTART, 7, 7, "", 3), &request));
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kRestart);
  EXPECT_EQ(request.step, 2) << "from 0";
  ASSERT_TRUE(ReadRequest(RequestBytes(teacher_t::RESTART, 0, 0, ""), &request));
  EXPECT_EQ(request.step, RestartRequest::kPresent);
}

TEST(TeacherLink, RefusesWhatIsNoRequest) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  TeacherRequest request;
  const int point = teacher_t::POINT;
  EXPECT_TRUE(ReadRequest(RequestBytes(point, 0.5, 0.5, std::string(60, 'x')), &request));
  for (const auto& bytes :
       {RequestBytes(point, 0.5, 0.5, std::string(61, 'x')), RequestBytes(point, 0.5, 0.5, "a\nb"),
        RequestBytes(point, 1.01, 0.5, ""), RequestBytes(point, 0.5, -0.01, ""),
        RequestBytes(point, kNan, 0.5, ""), RequestBytes(5, 0.5, 0.5, ""),
        RequestBytes(teacher_t::RESTART, 0, 0, "", -1), RequestBytes(-1, 0.5, 0.5, ""),
        std::vector<std::uint8_t>(40)}) {
    EXPECT_FALSE(ReadRequest(bytes, &request));
  }
}

TEST(TeacherLink, HandsOnWhatComesOnItsChannel) {
  SpscQueue<TeacherRequest> requests(8);
  TeacherLink link("memq://", &requests);
  const auto send = [&link](const char* channel, const std::vector<std::uint8_t>& bytes) {
    link.connection().publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size()));
  };
  send("OTHER", RequestBytes(teacher_t::PAUSE, 0, 0, ""));
  send(kTeacherChannel, std::vector<std::uint8_t>(10));
  send(kTeacherChannel, RequestBytes(teacher_t::BLEED, 0.25, 0.75, "clip it"));
  TeacherRequest request;
  bool came = false;
  for (int i = 0; i < 1000 && !came; ++i) {
    came = requests.Pop(&request);
    if (!came) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(came);
  EXPECT_EQ(request.kind, TeacherRequest::Kind::kBleed);
  EXPECT_EQ(request.x, 0.25);
  EXPECT_STREQ(request.text.data(), "clip it");
  EXPECT_FALSE(requests.Pop(&request));
}

}  // namespace
}  // namespace hpdm
