#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "lcmtypes/analysis/log_health.h"
#include "tests/support/spy_fixture.h"

// Tests hpdm spy as scripts call it.
namespace hpdm {
namespace {

using SpyOnceTest = SpyTest;

TEST_F(SpyOnceTest, ForeignTypesAreReadFromTheirFiles) {
  std::ofstream(folder_ / "pose.lcm") << "package robot; struct pose_t { int64_t sequence; double "
                                         "x[2]; string name; }";
  const std::string text =
      "package robot; struct pose_t { int64_t sequence; double x[2]; string "
      "name; }";
  const std::string name = "pose.lcm";
  const MessageSchemas schemas = MessageSchemas::HpdmAnd({&text, 1}, {&name, 1});
  {
    SessionLog log(log_, 0);
    for (int i = 0; i < 3; ++i) {
      std::vector<std::uint8_t> bytes;
      const auto big = [&bytes](std::uint64_t value, int size) {
        while (size-- > 0) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * size)));
      };
      big(static_cast<std::uint64_t>(schemas.structs().back().hash), 8);
      big(static_cast<std::uint64_t>(2 * i), 8);
      big(std::bit_cast<std::uint64_t>(1.5), 8);
      big(std::bit_cast<std::uint64_t>(std::nan("")), 8);
      big(3, 4);
      bytes.insert(bytes.end(), {'u', 'p', 0});
      log.Write("POSE", 1'000'000LL * i, bytes);
    }
  }
  const Ended ended = RunSpy(log_ + " --once --json --types " + folder_ / "pose.lcm", folder_);
  ASSERT_EQ(ended.code, 0) << ended.errors;
  const auto channel = nlohmann::json::parse(ended.output)["channels"][0];
  EXPECT_EQ(channel["type"], "robot.pose_t");
  EXPECT_EQ(channel["lost"], 2);
  const auto& values = channel["last"]["values"];
  EXPECT_EQ(values["sequence"], 4);
  EXPECT_EQ(values["x[0]"], 1.5);
  EXPECT_TRUE(values["x[1]"].is_null());
  EXPECT_EQ(values["name"], "up");
}

TEST_F(SpyOnceTest, OnceReportsTheSameAsTheLogCheck) {
  WriteLog();
  const Ended ended = RunSpy(log_ + " --once --json", folder_);
  ASSERT_EQ(ended.code, 0) << ended.errors;
  const auto json = nlohmann::json::parse(ended.output);
  EXPECT_NEAR(json["seconds"].get<double>(), 20, 1e-9);
  const LogHealth health = CheckLog(log_, MessageSchemas::Hpdm());
  ASSERT_EQ(json["channels"].size(), health.channels.size());
  for (std::size_t i = 0; i < health.channels.size(); ++i) {
    const auto& channel = json["channels"][i];
    EXPECT_EQ(channel["channel"], health.channels[i].channel);
    EXPECT_EQ(channel["messages"], health.channels[i].messages);
    EXPECT_EQ(channel["lost"], health.channels[i].lost);
    EXPECT_EQ(channel["mean_rate_hz"], health.channels[i].Rate());
  }
  EXPECT_EQ(json["channels"][2]["last"]["values"]["tools[0].p_tip[0]"], 0.25);
  EXPECT_EQ(json["channels"][2]["last"]["units"]["tools[0].p_tip[0]"], "m");
  EXPECT_FALSE(json["channels"][2]["last"]["units"].contains("sequence"));
  EXPECT_FALSE(json["channels"][0].contains("last"));  // of no known type
  // Reads a part: from 5 s on, for 2 s, without the time before.
  const auto part =
      nlohmann::json::parse(RunSpy(log_ + " --once --json --from 5 --seconds 2", folder_).output);
  EXPECT_NEAR(part["channels"][1]["messages"].get<double>(), 200, 1);  // with both ends or not
}

TEST_F(SpyOnceTest, WithoutATerminalItNamesOnceAndNothingIsAFailure) {
  WriteLog();
  const Ended piped = RunSpy(log_, folder_);
  EXPECT_EQ(piped.code, 2);
  EXPECT_NE(piped.errors.find("--once"), piped.errors.npos);
  EXPECT_EQ(std::count(piped.errors.begin(), piped.errors.end(), '\n'), 1);
  EXPECT_EQ(RunSpy("--once --speed 2", folder_).code, 2);
  EXPECT_EQ(RunSpy(log_ + " --json", folder_).code, 2);
  EXPECT_EQ(RunSpy(folder_ / "none.lcmlog" + " --once", folder_).code, 2);
  const Ended types = RunSpy(log_ + " --once --types /" + std::string(5000, 'x'), folder_);
  EXPECT_EQ(types.code, 2) << "a path too long is one that cannot be read";
  EXPECT_EQ(std::count(types.errors.begin(), types.errors.end(), '\n'), 1) << types.errors;
  std::ofstream(folder_ / "empty.lcmlog").flush();
  const Ended empty = RunSpy(folder_ / "empty.lcmlog" + " --once", folder_);
  EXPECT_EQ(empty.code, 1);
  EXPECT_EQ(std::count(empty.errors.begin(), empty.errors.end(), '\n'), 1) << empty.errors;
}

}  // namespace
}  // namespace hpdm
