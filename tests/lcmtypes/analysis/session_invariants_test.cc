#include "lcmtypes/analysis/session_invariants.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/output_thinning.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr Nanoseconds kTick = 1'000'000;
constexpr int kTicks = 2400;
constexpr int kStepTicks = 33;

/// A session's log of one tick: a probe presses for 200 ms of every 400, with up to 1 N.
struct Tick {
  HapticSample input, output;
  bool has_input = true, has_output = true;
};
/// The session's log of one step.
struct Step {
  StepSample sample;
  std::int64_t visible_tick = 0;
  OrganSnapshot shape;
  bool shape_first = true;
};

/// A log of a session that is as it must be, but for what a test changes in it.
class SessionInvariants : public testing::Test {
 protected:
  using Changes = std::function<void(Tick*)>;
  using StepChanges = std::function<void(Step*)>;

  static bool Presses(std::uint64_t tick) { return tick % 400 >= 200; }
  // N, and m of depth with a compliance of 10 mm/N.
  static double ForceAt(std::uint64_t tick) {
    return Presses(tick) ? std::sin(M_PI * static_cast<double>(tick % 400 - 200) / 200) : 0;
  }

  void WriteTick(std::uint64_t tick, SessionLog* log, const Changes& change) {
    HapticSample sample;
    sample.tick = tick;
    sample.time_ns = static_cast<Nanoseconds>(tick) * kTick;
    sample.tool_count = 1;
    ToolSample& tool = sample.tools[0];
    tool.joints[kInsertion] = 0.1 + 0.01 * ForceAt(tick);
    tool.force_W = tool.reaction_W = ForceAt(tick) * Vector3d::UnitZ();
    tool.p_tip_W = -0.01 * tool.reaction_W;
    tool.kind = Presses(tick) ? ContactKind::kPress : ContactKind::kNone;
    tool.energy = 0.01 * ForceAt(tick) * ForceAt(tick) / 2;
    Tick written = {sample, sample};
    if (change) change(&written);
    if (written.has_input) {
      tool_t message{};
      ToMessage(written.input, &message);
      message.sequence = ++tool_sequence_;
      log->Write(kToolChannel, sample.time_ns, EncodeMessage(message, &buffer_));
    }
    if (written.has_output) {
      force_t message{};
      ToMessage(written.output, &message);
      message.sequence = ++force_sequence_;
      log->Write(kForceChannel, sample.time_ns, EncodeMessage(message, &buffer_));
    }
  }

  void WriteStep(std::uint64_t tick, SessionLog* log, const StepChanges& change) {
    Step step;
    StepRecord& record = step.sample.step;
    record.number = tick / kStepTicks + 1;
    record.input_tick = tick;
    record.time_ns = static_cast<Nanoseconds>(tick) * kTick;
    step.sample.organ_count = 1;
    step.sample.tool_count = 1;
    step.visible_tick = static_cast<std::int64_t>(tick) + 34;
    SolvedContact& contact = step.sample.contacts[0];
    contact.organ = 0;
    contact.kind = ContactKind::kPress;
    contact.reaction = ReactionType::kLattice;
    contact.force_on_tissue_W = -ForceAt(tick) * Vector3d::UnitZ();
    contact.contact_W = 0.01 * contact.force_on_tissue_W;
    step.shape.control_displacements = Points::Zero(8, 3);
    step.shape.control_displacements.row(2) = contact.contact_W;
    if (change) change(&step);
    const auto write_shape = [&] {
      organ_t message{};
      ToMessage(record, 0, step.shape, &message);
      log->Write(kOrganChannel, record.time_ns, EncodeMessage(message, &buffer_));
    };
    if (step.shape_first) write_shape();
    contact_t message{};
    ToMessage(step.sample, step.visible_tick, &message);
    log->Write(kContactChannel, record.time_ns, EncodeMessage(message, &buffer_));
    if (!step.shape_first) write_shape();
  }

  /// Makes the next sessions' logs say that they hold the output of one tick in `interval`. The
  /// changes leave them out.
  void Thin(int interval) { interval_ = interval; }
  /// Leaves out the outputs that a log of --log-rate 100 lacks.
  static void LeaveOut(Tick* tick) { tick->has_output = tick->input.tick % 10 == 0; }

  void WriteSession(const Changes& change, const StepChanges& step_change = nullptr) {
    SessionLog log(log_, 0);
    if (interval_ > 1) {
      event_t message{};
      message.name = kLogThinned;
      message.text = ThinnedText(interval_);
      log.Write(kEventChannel, 0, EncodeMessage(message, &buffer_));
    }
    for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
      WriteTick(tick, &log, change);
      if (tick % kStepTicks == 0) WriteStep(tick, &log, step_change);
    }
  }

  /// Names of the broken invariants, joined.
  std::string Broken(Nanoseconds period = 0) {
    invariants_ = CheckInvariants(log_, limits_, period);
    std::string names;
    for (const Invariant& invariant : invariants_) {
      if (!invariant.Holds()) names += (names.empty() ? "" : " ") + invariant.name;
    }
    return names;
  }
  const Invariant& Find(const std::string& name) const {
    for (const Invariant& invariant : invariants_) {
      if (invariant.name == name) return invariant;
    }
    throw std::runtime_error("no invariant " + name);
  }

  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
  SessionLimits limits_ = {.tools = {{.max_force = 2, .slew = 0.1}}, .settles = {0.0}};
  std::vector<Invariant> invariants_;
  std::vector<std::uint8_t> buffer_;
  std::int64_t tool_sequence_ = 0, force_sequence_ = 0;
  int interval_ = 1;
};

TEST_F(SessionInvariants, HoldInASessionThatIsAsItMustBe) {
  WriteSession(nullptr);
  EXPECT_EQ(Broken(400 * kTick), "");
  for (const Invariant& invariant : invariants_) {
    EXPECT_GT(invariant.checked, 0u) << invariant.name;
    EXPECT_FALSE(invariant.first) << invariant.name;
  }
  EXPECT_NEAR(Find("force").worst, 0.5, 1e-4);   // 1 N of 2 N, but for the sine's samples
  EXPECT_NEAR(Find("slew").worst, 0.157, 1e-3);  // pi / 200 N of 0.1 N
  EXPECT_EQ(Find("repeats").checked, kTicks - 800u);
}

TEST_F(SessionInvariants, NameANumberThatIsNotFinite) {
  WriteSession(nullptr, [](Step* step) {
    if (step->sample.step.number == 5) step->shape.control_displacements(7, 1) = kNan;
  });
  // The tool presses then: nothing is at rest that could be judged.
  EXPECT_EQ(Broken(), "finite");
  EXPECT_EQ(Find("finite").broken, 1u);
  EXPECT_NEAR(*Find("finite").first, 0.132, 1e-9);
}

TEST_F(SessionInvariants, MissATickThatIsNotInTheLog) {
  WriteSession([](Tick* tick) { tick->has_input = tick->has_output = tick->input.tick != 1000; });
  EXPECT_EQ(Broken(), "ticks");
  EXPECT_EQ(Find("ticks").worst, 1);
}

TEST_F(SessionInvariants, MissATickWithoutOutput) {
  WriteSession([](Tick* tick) { tick->has_output = tick->input.tick != 1000; });
  EXPECT_EQ(Broken(), "ticks");
}

TEST_F(SessionInvariants, TakeAThinnedLog) {
  Thin(10);
  WriteSession(LeaveOut);
  EXPECT_EQ(Broken(400 * kTick), "");
  EXPECT_EQ(Find("ticks").checked, static_cast<std::uint64_t>(kTicks));
  EXPECT_EQ(Find("force").checked, kTicks / 10u);
  EXPECT_NEAR(Find("slew").worst, 0.156, 1e-3);  // the mean over 10 ticks of pi / 200 N
  EXPECT_EQ(Find("repeats").checked, (kTicks - 800u) / 10);
}

TEST_F(SessionInvariants, MissAnInputOrAnOutputOfAThinnedLog) {
  Thin(10);
  WriteSession([](Tick* tick) {
    LeaveOut(tick);
    if (tick->input.tick == 1005) tick->has_input = false;
  });
  EXPECT_EQ(Broken(), "ticks");
  EXPECT_NEAR(*Find("ticks").first, 1.006, 1e-9);
  WriteSession([](Tick* tick) {
    LeaveOut(tick);
    if (tick->input.tick == 1010) tick->has_output = false;
  });
  EXPECT_EQ(Broken(), "ticks");
  EXPECT_EQ(Find("ticks").broken, 1u);
  EXPECT_NEAR(*Find("ticks").first, 1.010, 1e-9);
}

TEST_F(SessionInvariants, TakeAnIntervalThatBeginsWithASkippedTick) {
  Thin(10);
  WriteSession([](Tick* tick) {
    const std::uint64_t number = tick->input.tick;
    tick->has_input = number != 1010;
    tick->has_output = number == 1011 || (tick->has_input && number % 10 == 0);
    if (number == 1011) tick->input.skipped.stalled = 1;
  });
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, NameAnAlteredOutputOfAThinnedLog) {
  Thin(10);
  // A change of 1.1 N in ten ticks of 0.1 N.
  WriteSession([](Tick* tick) {
    LeaveOut(tick);
    if (tick->output.tick == 900) tick->output.tools[0].force_W.y() = 1.1;
  });
  EXPECT_EQ(Broken(), "slew");
  EXPECT_EQ(Find("slew").broken, 2u);
  WriteSession([](Tick* tick) {
    LeaveOut(tick);
    double& force = tick->output.tools[0].force_W.z();
    if (tick->output.tick == 1500) force = std::nextafter(force, 2);
  });
  EXPECT_EQ(Broken(400 * kTick), "repeats");
}

TEST_F(SessionInvariants, TakeASkippedTickWithACause) {
  WriteSession([](Tick* tick) {
    tick->has_input = tick->has_output = tick->input.tick != 1000;
    if (tick->input.tick == 1001) tick->input.skipped.stalled = 1;
  });
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, NameAForceBeyondTheDevice) {
  // The force rises and falls within its slew limit.
  WriteSession([](Tick* tick) { tick->output.tools[0].force_W *= 2.01; });
  EXPECT_EQ(Broken(), "force");
  EXPECT_NEAR(Find("force").worst, 1.005, 1e-4);
}

TEST_F(SessionInvariants, NameAForceThatIsNotANumber) {
  WriteSession([](Tick* tick) {
    if (tick->output.tick == 1100) tick->output.tools[0].force_W.x() = kNan;
  });
  EXPECT_EQ(Broken(), "finite force slew");
}

TEST_F(SessionInvariants, NameAJumpOfAForce) {
  WriteSession([](Tick* tick) {
    if (tick->output.tick >= 1050) tick->output.tools[0].force_W.x() += 0.11;
  });
  EXPECT_EQ(Broken(), "slew");
  EXPECT_EQ(Find("slew").broken, 1u);
  EXPECT_NEAR(*Find("slew").first, 1.050, 1e-9);
}

TEST_F(SessionInvariants, LetAForceEndAtOnceWhenItIsSwitchedOff) {
  WriteSession([](Tick* tick) {
    if (tick->output.tick < 1100) return;
    tick->output.tools[0].force_W.setZero();
    tick->output.tools[0].guard_flags = kGuardDisabled;
    tick->output.tools[0].energy = 0;
  });
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, NameEnergyFromNowhere) {
  // The hand's work falls by 30 mW, also while it presses without moving.
  WriteSession(
      [](Tick* tick) { tick->output.tools[0].energy -= 0.03 * ToSeconds(tick->output.time_ns); });
  EXPECT_EQ(Broken(), "work");
  EXPECT_NEAR(Find("work").worst, 0.03, 1e-6);
  limits_.still = false;  // then it may be the organ's own
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, NameAStepThatIsMissing) {
  WriteSession(nullptr, [](Step* step) {
    if (step->sample.step.number >= 20) ++step->sample.step.number;
  });
  EXPECT_EQ(Broken(), "steps");
  EXPECT_EQ(Find("steps").broken, 1u);
}

TEST_F(SessionInvariants, NameAPatchThatWasSeenBeforeItsStep) {
  WriteSession(nullptr, [](Step* step) {
    if (step->sample.step.number == 20) step->visible_tick -= 35;
  });
  EXPECT_EQ(Broken(), "steps");
}

TEST_F(SessionInvariants, NameAContactThatGivesEnergy) {
  // It pushes harder on the way out.
  const auto more = [](Tick* tick) {
    if (tick->output.tick % 400 >= 300) tick->output.tools[0].force_W *= 1.05;
  };
  WriteSession(more);
  EXPECT_EQ(Broken(), "energy");
  EXPECT_NEAR(Find("energy").worst, 0.05, 2e-3);
  EXPECT_EQ(Find("energy").broken, 5u) << "each contact is judged";
  limits_.still = false;  // then it may be the organ's own
  EXPECT_EQ(Broken(), "");
  limits_.still = true;
  WriteSession([&](Tick* tick) {
    more(tick);
    if (tick->output.tick % 400 == 250) tick->output.tools[0].kind = ContactKind::kGrasp;
  });
  EXPECT_EQ(Broken(), "") << "jaws do work";
}

// A contact takes 5 mJ and gives 5 % more back, of which 3 % are allowed.
TEST_F(SessionInvariants, LetAFreeOrganGiveWhatItHas) {
  const auto more = [](Tick* tick) {
    if (tick->output.tick % 400 >= 300) tick->output.tools[0].force_W *= 1.05;
  };
  const auto falls = [](double power) {
    return [=](Step* step) {
      step->sample.organs[0].body_energy = -power * ToSeconds(step->sample.step.time_ns);
    };
  };
  WriteSession(more, falls(0.8e-3));  // 0.3 s and 0.1 of patches
  EXPECT_EQ(Broken(), "");
  EXPECT_NEAR(Find("energy").worst, 0.05 - 0.8e-3 * 0.33 / 0.005, 0.025);
  WriteSession(more, falls(0.1e-3));
  EXPECT_EQ(Broken(), "energy") << "it has given less";
  WriteSession(more, falls(-1));
  EXPECT_EQ(Broken(), "energy") << "it has taken more";
  const auto gains = [](Tick* tick) {
    tick->output.tools[0].energy -= 0.03 * ToSeconds(tick->output.time_ns);
  };
  WriteSession(gains, falls(0.02));
  EXPECT_EQ(Broken(), "");
  WriteSession(gains, falls(0.005));
  EXPECT_EQ(Broken(), "work");
}

// The tissue still holds the energy: the steps release it later.
TEST_F(SessionInvariants, LetAToolLoseItsPlaceForATick) {
  WriteSession([](Tick* tick) {
    if (tick->output.tick % 400 != 300) return;
    tick->output.tools[0].kind = ContactKind::kNone;
    tick->output.tools[0].reaction_W.setZero();
  });
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, LetFrictionDissipate) {
  WriteSession([](Tick* tick) {
    // From the deepest point on it gives less and less back.
    const double out = (static_cast<double>(tick->output.tick % 400) - 300) / 100;
    if (out > 0) tick->output.tools[0].force_W *= 1 - 0.5 * out;
  });
  EXPECT_EQ(Broken(), "");
}

TEST_F(SessionInvariants, NameAnOrganThatDoesNotComeBack) {
  // Shape and step come in either order, as in real sessions.
  for (const bool shape_first : {true, false}) {
    WriteSession(nullptr, [&](Step* step) {
      step->shape_first = shape_first;
      if (step->sample.step.number > 40) step->shape.control_displacements(3, 0) += 2e-6;
    });
    EXPECT_EQ(Broken(), "rest") << shape_first;
    EXPECT_NEAR(Find("rest").worst, 2e-6, 1e-12) << shape_first;
  }
}

// A layer tears from step 10 to step 30, up to 1 cm^2 and 4.5 mJ.
void Tear(Step* step) {
  AttachmentOutcome& outcome = step->sample.attachments[0];
  step->sample.attachment_count = 1;
  const double torn =
      std::clamp((static_cast<double>(step->sample.step.number) - 10) / 20, 0.0, 1.0);
  outcome = {.largest_damage = torn, .freed_area = 1e-4 * torn, .dissipated = 4.5e-3 * torn};
}

TEST_F(SessionInvariants, LetALayerTear) {
  WriteSession(nullptr, Tear);
  EXPECT_EQ(Broken(), "");
  EXPECT_GT(Find("damage").checked, 70u);
}

TEST_F(SessionInvariants, NameATearThatHeals) {
  for (double AttachmentOutcome::*part :
       {&AttachmentOutcome::largest_damage, &AttachmentOutcome::freed_area,
        &AttachmentOutcome::dissipated}) {
    WriteSession(nullptr, [part](Step* step) {
      Tear(step);
      if (step->sample.step.number == 40) step->sample.attachments[0].*part *= 0.75;
    });
    EXPECT_EQ(Broken(), "damage");
    EXPECT_NEAR(Find("damage").worst, 0.25, 1e-12);
    EXPECT_NEAR(*Find("damage").first, 39 * kStepTicks * 1e-3, 1e-9);
  }
}

TEST_F(SessionInvariants, GiveACreepingOrganItsTime) {
  // Longer than any pause: it is never judged.
  limits_.settles = {0.5};
  WriteSession(nullptr, [&](Step* step) {
    if (step->sample.step.number > 40) step->shape.control_displacements(3, 0) += 2e-6;
  });
  EXPECT_EQ(Broken(), "");
  EXPECT_EQ(Find("rest").checked, 0u);
}

TEST_F(SessionInvariants, LetAToolOnAnotherOrganPushTheOrgan) {
  const auto press_another = [](Step* step) {
    if (step->sample.step.number > 40) step->sample.contacts[0].organ = 1;
  };
  limits_.settles = {0.0, 0.0};
  limits_.pushing = {0, 0};
  WriteSession(nullptr, press_another);
  EXPECT_EQ(Broken(), "");
  EXPECT_GT(Find("rest").checked, 0u);
  limits_.pushing = {0, 1};
  EXPECT_EQ(Broken(), "rest");
}

TEST_F(SessionInvariants, NameTheLastBitOfAForceThatIsNotRepeated) {
  WriteSession([](Tick* tick) {
    double& force = tick->output.tools[0].force_W.z();
    if (tick->output.tick == 1500) force = std::nextafter(force, 2);
  });
  EXPECT_EQ(Broken(), "");
  EXPECT_EQ(Broken(400 * kTick), "repeats");
  EXPECT_EQ(Find("repeats").broken, 1u);
  EXPECT_GT(Find("repeats").worst, 0);
}

TEST_F(SessionInvariants, DoNotTakeAnotherMotionForARepetition) {
  WriteSession([](Tick* tick) {
    if (tick->input.tick == 1500) tick->input.tools[0].joints[kYaw] = 1e-9;
  });
  EXPECT_EQ(Broken(400 * kTick), "repeats");
}

TEST_F(SessionInvariants, TakeAnyNumbersWithoutHarm) {
  // Damaged logs may contain such numbers; the address sanitizer watches.
  WriteSession(
      [](Tick* tick) {
        if (tick->input.tick % 100 == 7) {
          tick->input.time_ns = tick->output.time_ns = std::numeric_limits<std::int64_t>::min();
        }
      },
      [](Step* step) {
        step->sample.contacts[0].organ = std::numeric_limits<std::int32_t>::max();
        step->sample.step.time_ns = std::numeric_limits<std::int64_t>::max();
        if (step->sample.step.number % 2 == 0)
          step->shape.control_displacements = Points::Ones(3, 3);
      });
  EXPECT_NO_THROW(Broken(400 * kTick));
}

}  // namespace
}  // namespace hpdm
