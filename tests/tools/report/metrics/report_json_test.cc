#include "tools/report/metrics/report_json.h"

#include <gtest/gtest.h>

#include "tests/support/made_session.h"

namespace hpdm {
namespace {

TEST(ReportJson, ALayerHasItsLargestLoadAndItsLastDamage) {
  MadeSession session;
  session.Press(40, 2, 0);
  session.Step({{}, {.load_W = {0, 3, 4}, .largest_damage = 0.5, .dissipated = 1e-3}});
  session.Press(40, 2, 0);
  session.Step(
      {{}, {.load_W = {1, 0, 0}, .largest_damage = 1, .freed_area = 2e-4, .dissipated = 3e-3}});
  const SessionReport report = session.Finish().report;
  ASSERT_EQ(report.attachments.size(), 2u);
  EXPECT_EQ(report.attachments[0].peak_load, 0);
  const auto layer = ToJson(report)["attachments"][1];
  EXPECT_EQ(layer["name"], "attachment 2");
  EXPECT_EQ(layer["peak_load_N"], 5);
  EXPECT_EQ(layer["largest_damage"], 1);
  EXPECT_EQ(layer["freed_area_m2"], 2e-4);
  EXPECT_EQ(layer["dissipated_J"], 3e-3);
}

TEST(ReportJson, KeysCarryUnits) {
  MadeSession session;
  session.Press(300, 2, 0);
  const auto json = ToJson(session.Finish().report);
  const auto& hand = json["hands"][0];
  for (const char* key : {"time_s",
                          "path_length_m",
                          "angular_path_rad",
                          "roll_path_rad",
                          "insertion_path_m",
                          "economy_of_motion",
                          "movements",
                          "mean_speed_m_per_s",
                          "peak_speed_m_per_s",
                          "smoothness_sparc",
                          "idle_s",
                          "contact_time_s",
                          "contacts",
                          "peak_force_N",
                          "mean_force_N",
                          "force_impulse_Ns",
                          "over_limit_s",
                          "over_limit_count",
                          "deepest_press_m",
                          "over_depth_s",
                          "over_depth_count",
                          "mean_force_rate_N_per_s",
                          "peak_force_rate_N_per_s",
                          "device_lost_s",
                          "organs"}) {
    EXPECT_TRUE(hand.contains(key)) << key;
  }
  EXPECT_TRUE(hand["economy_of_motion"].is_null());
  EXPECT_EQ(hand["organs"][0]["organ"], "liver");
  EXPECT_EQ(json["start"], nullptr);
  EXPECT_EQ(json["log_health"]["sound"], true);
}

}  // namespace
}  // namespace hpdm
