#include "lcmtypes/telemetry/event_reporter.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/telemetry_fixture.h"

namespace hpdm {
namespace {

/// A reporter of two hands and a liver, with everything that it reports.
struct ReporterBench {
  struct Event {
    EventSeverity severity;
    std::string name, text;
  };
  static constexpr double kBedArea = 3e-4;  // m^2
  static SessionInfo Info() {
    SessionInfo info = TwoProbesAndALiver();
    info.held = {{"left"}, {"right", "hook", "scissors"}};
    info.attachments = {{"gallbladder and liver", kBedArea}};
    info.layers = {{"layer[0] of liver", 300}, {"layer[1] of liver", 0}};
    info.lumens = {"the lumen of gallbladder"};
    info.ducts = {"cystic duct"};
    return info;
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const Event& event : events) names.push_back(event.name);
    return names;
  }

  std::vector<Event> events;
  std::vector<std::string> told;
  EventReporter reporter{
      Info(),
      [this](EventSeverity severity, const std::string& name, const std::string& text) {
        events.push_back({severity, name, text});
      },
      [this](const std::string& line) { told.push_back(line); }};
};

using Names = std::vector<std::string>;

StepSample Step(std::uint64_t number) {
  StepSample sample;
  sample.step.number = number;
  sample.step.time_ns = static_cast<Nanoseconds>(number) * 33 * kTickPeriod;
  sample.organ_count = 1;
  return sample;
}

TEST(EventReporter, TheStartListsTheInstrumentsAndTheMachinesOwnLateness) {
  ReporterBench bench;
  bench.reporter.ReportStart({});
  ASSERT_EQ(bench.Names(), Names{"session.start"});
  EXPECT_EQ(bench.events[0].text, "instruments: left, right");
  Histogram baseline;
  for (int i = 1; i <= 1000; ++i) baseline.Add(10 * i);
  bench.reporter.ReportStart(baseline);
  EXPECT_EQ(bench.events.back().name, "realtime.baseline");
  EXPECT_NE(bench.events.back().text.find("10.0 us at most"), std::string::npos);
}

TEST(EventReporter, ADeviceThatIsLostAndComesBackIsTwoEventsAtTheirTicks) {
  ReporterBench bench;
  for (std::uint64_t tick = 0; tick < 300; ++tick) {
    HapticSample sample = Sample(tick, 0);
    sample.tools[1].device_valid = tick < 100 || tick >= 250;
    bench.reporter.Add(sample);
    EXPECT_EQ(bench.events.size(), tick < 100 ? 0u : tick < 250 ? 1u : 2u) << tick;
  }
  ASSERT_EQ(bench.Names(), (Names{"device.lost", "device.back"}));
  EXPECT_EQ(bench.events[0].severity, EventSeverity::kWarning);
  EXPECT_TRUE(bench.events[0].text.starts_with("right: "));
}

TEST(EventReporter, EachSlipInAHandsJawsIsOneEventAtItsFirstTick) {
  ReporterBench bench;
  std::vector<std::uint64_t> reported;
  for (std::uint64_t tick = 0; tick < 1500; ++tick) {
    HapticSample sample = Sample(tick, 0);
    const auto slipped = [tick](std::uint64_t from, std::uint64_t to) {
      return 1e-6 * static_cast<double>(std::clamp(tick, from, to) - from);
    };
    sample.tools[0].slip = slipped(200, 300);
    sample.tools[1].slip = slipped(200, 500) + slipped(900, 1000);
    const std::size_t before = bench.events.size();
    bench.reporter.Add(sample);
    for (std::size_t i = before; i < bench.events.size(); ++i) reported.push_back(tick);
  }
  ASSERT_EQ(bench.Names(), (Names{"grasp.slipped", "grasp.slipped", "grasp.slipped"}));
  EXPECT_EQ(reported, (std::vector<std::uint64_t>{201, 201, 901}));
  EXPECT_TRUE(bench.events[0].text.starts_with("left: "));
  EXPECT_TRUE(bench.events[1].text.starts_with("right: "));
  EXPECT_TRUE(bench.events[2].text.starts_with("right: "));
  EXPECT_EQ(bench.events[0].severity, EventSeverity::kInfo);
}

TEST(EventReporter, TheUserIsToldOfAMissingDriverOfALossAndOfAReturn) {
  ReporterBench bench;
  for (std::uint64_t tick = 0; tick < 6000; ++tick) {
    HapticSample sample = Sample(tick, 0);
    sample.tools[1].device_valid = tick >= 1500 && (tick < 3000 || tick >= 4500);
    bench.reporter.Add(sample);
    EXPECT_EQ(bench.told.size(), tick < 1500 ? 1u : tick < 3000 ? 2u : tick < 4500 ? 3u : 4u);
  }
  EXPECT_EQ(bench.told, (std::vector<std::string>{
                            "right: waiting for a driver on HPDM_DEVICE",
                            "right: device connected: force fading in",
                            "right: device lost: pose held, force fading out",
                            "right: device back: force fading in",
                        }));
  EXPECT_EQ(bench.Names(), (Names{"device.connected", "device.lost", "device.back"}))
      << "a device that was never there is not lost";
}

TEST(EventReporter, OfAStutteringDriverTheUserIsToldOnceASecondAndItsLastState) {
  ReporterBench bench;
  for (std::uint64_t tick = 0; tick < 6000; ++tick) {
    HapticSample sample = Sample(tick, 0);
    sample.tools[0].device_valid = tick >= 3000 || tick % 100 < 50;
    bench.reporter.Add(sample);
  }
  EXPECT_EQ(bench.events.size(), 60u);
  EXPECT_LE(bench.told.size(), 4u);
  ASSERT_GE(bench.told.size(), 2u);
  EXPECT_EQ(bench.told.back(), "left: device back: force fading in");
}

TEST(EventReporter, APauseAndAnExchangeAreEventsWhenTheyBegin) {
  ReporterBench bench;
  for (std::uint64_t tick = 0; tick < 60; ++tick) {
    HapticSample sample = Sample(tick, 0);
    sample.paused = tick >= 10 && tick < 20;
    sample.tools[1].instrument_index = tick < 30 ? 0 : tick < 40 ? 2 : 0;
    bench.reporter.Add(sample);
  }
  ASSERT_EQ(bench.Names(), (Names{"session.paused", "session.resumed", "instrument.exchanged",
                                  "instrument.exchanged"}));
  EXPECT_NE(bench.events[2].text.find("scissors"), std::string::npos);
  EXPECT_TRUE(bench.events[3].text.starts_with("right: "));
}

TEST(EventReporter, AnInvertedOrganIsTwoEventsHoweverOftenItInverts) {
  ReporterBench bench;
  for (std::uint64_t number = 1; number <= 60; ++number) {
    StepSample sample = Step(number);
    sample.organs[0].inverted = number >= 10 && number < 20 && number % 2 == 0;
    sample.organs[0].recovering = number >= 40;
    bench.reporter.Add(sample);
    // 0.25 s after step 18.
    EXPECT_EQ(bench.events.size(), number < 10   ? 0u
                                   : number < 26 ? 1u
                                   : number < 40 ? 2u
                                                 : 3u)
        << number;
  }
  ASSERT_EQ(bench.Names(), (Names{"organ.inverted", "organ.recovered", "organ.inverted"}));
  EXPECT_EQ(bench.events[0].severity, EventSeverity::kWarning);
  EXPECT_TRUE(bench.events[0].text.starts_with("liver: tissue is turned inside out"));
  EXPECT_EQ(bench.events[1].severity, EventSeverity::kInfo);
  EXPECT_TRUE(bench.events[2].text.starts_with("liver: its tools ask for more"));
}

TEST(EventReporter, ALayersFirstDamageItsFirstTearAndItsEndAreOneEventEach) {
  ReporterBench bench;
  for (std::uint64_t number = 1; number <= 60; ++number) {
    StepSample sample = Step(number);
    sample.attachment_count = 1;
    AttachmentOutcome& layer = sample.attachments[0];
    if (number >= 10) layer.largest_damage = 0.5;
    if (number >= 20) layer.largest_damage = 1;
    if (number >= 20) layer.freed_area = 1e-5;
    if (number >= 40) layer.freed_area = ReporterBench::kBedArea * (1 - 1e-15);
    bench.reporter.Add(sample);
    EXPECT_EQ(bench.events.size(), number < 10   ? 0u
                                   : number < 20 ? 1u
                                   : number < 40 ? 2u
                                                 : 3u)
        << number;
  }
  EXPECT_EQ(bench.Names(), (Names{"attachment.damaged", "attachment.tears", "attachment.torn"}));
  EXPECT_EQ(bench.events[2].text, "the layer between gallbladder and liver is torn through");
}

TEST(EventReporter, ALayerBeyondItsStrengthIsAnEventUntilItIsUnloaded) {
  ReporterBench bench;
  std::uint64_t number = 0;
  for (const double tension : {100.0, 299.0, 310.0, 290.0, 320.0, 269.0, 305.0}) {
    StepSample sample = Step(++number);
    sample.layer_count = 2;
    sample.layer_tensions[0] = tension;
    sample.layer_tensions[1] = 1e6;
    bench.reporter.Add(sample);
    EXPECT_EQ(bench.events.size(), number < 3 ? 0u : number < 7 ? 1u : 2u) << number;
  }
  EXPECT_EQ(bench.Names(), (Names{"layer.overloaded", "layer.overloaded"}));
  EXPECT_EQ(bench.events[0].text,
            "layer[0] of liver bears 310 N/m, beyond its strength of 300 N/m");
}

TEST(EventReporter, ALumenIsPerforatedOnce) {
  ReporterBench bench;
  for (std::uint64_t number = 1; number < 9; ++number) {
    StepSample sample = Step(number);
    sample.lumen_count = 1;
    sample.lumens[0].perforated = number >= 4;
    bench.reporter.Add(sample);
    EXPECT_EQ(bench.events.size(), number < 4 ? 0u : 1u) << number;
  }
  EXPECT_EQ(bench.Names(), (Names{"lumen.perforated"}));
  EXPECT_EQ(bench.events[0].text, "the lumen of gallbladder is perforated and leaks");
}

TEST(EventReporter, EachClipAndEachCutOfADuctIsAnEvent) {
  ReporterBench bench;
  std::uint64_t number = 0;
  for (const auto& [clips, cuts] : {std::pair(0, 0), {1, 0}, {1, 0}, {3, 0}, {3, 1}, {3, 1}}) {
    StepSample sample = Step(++number);
    sample.duct_count = 1;
    sample.ducts[0].clips = clips;
    sample.ducts[0].cuts = cuts;
    bench.reporter.Add(sample);
  }
  EXPECT_EQ(bench.Names(), (Names{"duct.clipped", "duct.clipped", "duct.clipped", "duct.cut"}));
  EXPECT_EQ(bench.events[2].text, "clip 3 is on the cystic duct");
  EXPECT_EQ(bench.events[3].text, "the cystic duct is cut, with 3 clips on it");
}

TEST(EventReporter, EachLevelOfReducedQualityIsAnEvent) {
  ReporterBench bench;
  for (std::uint64_t number = 1; number <= 60; ++number) {
    StepSample sample = Step(number);
    sample.step.shed_level = number < 10 || number >= 50 ? 0 : number < 20 || number >= 40 ? 1 : 2;
    bench.reporter.Add(sample);
  }
  EXPECT_EQ(bench.Names(), (Names{"steps.shed", "steps.shed", "steps.raised", "steps.restored"}));
}

TEST(EventReporter, TheUserIsToldOfALoopsWarningsOnly) {
  ReporterBench bench;
  bench.reporter.Add(MakeLoopEvent(EventSeverity::kInfo, "render.started", "a"));
  bench.reporter.Add(MakeLoopEvent(EventSeverity::kError, "render.ended", "b"));
  EXPECT_EQ(bench.Names(), (Names{"render.started", "render.ended"}));
  EXPECT_EQ(bench.told, std::vector<std::string>{"b"});
}

TEST(EventReporter, LossesAreReportedPerInterval) {
  ReporterBench bench;
  bench.reporter.AddLosses(0, 0);
  bench.reporter.AddLosses(4, 0);
  bench.reporter.AddLosses(4, 0);
  bench.reporter.AddLosses(9, 2);
  ASSERT_EQ(bench.Names(),
            (Names{"telemetry.overflow", "telemetry.overflow", "telemetry.steps_lost"}));
  EXPECT_TRUE(bench.events[1].text.starts_with("5 ticks "));
  EXPECT_TRUE(bench.events[2].text.starts_with("2 deformation steps "));
}

TEST(EventReporter, EachKindOfFailureIsReportedAndToldOnce) {
  ReporterBench bench;
  LogState log;
  bench.reporter.AddFailures(log, "", 0);
  EXPECT_TRUE(bench.events.empty());
  log.moved = true;
  log.failure = LogFailure::kVanished;
  for (int i = 0; i < 3; ++i) bench.reporter.AddFailures(log, "no rows", 1);
  EXPECT_EQ(bench.Names(), (Names{"log.failed", "timeline.failed", "live.failed"}))
      << "a log that has failed is not reported as moved";
  EXPECT_EQ(bench.events[0].severity, EventSeverity::kError);
  ASSERT_EQ(bench.told.size(), 3u);
  EXPECT_EQ(bench.told[0], log.Explain());
  EXPECT_EQ(bench.told[1], "no rows");
}

}  // namespace
}  // namespace hpdm
