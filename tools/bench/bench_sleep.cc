#include <filesystem>
#include <string>

#include "engine/base/check.h"
#include "haptics/haptic_loop.h"
#include "tools/bench/bench_results.h"
#include "tools/bench/bench_scene.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

constexpr const char* kStressScene = "scenes/stress.toml";

// Times a cycle of two steps, in and out, as one.
std::function<void()> Cycle(BenchScene* scene) {
  return [scene] {
    scene->Step();
    scene->Step();
  };
}

SleepResults TimeAmong(const BenchOrgan& touched, const BenchOrgan& other, int sleeping,
                       BenchScene* alone, bool quick) {
  std::vector<BenchOrgan> organs = {touched};
  organs.insert(organs.end(), static_cast<std::size_t>(sleeping), other);
  BenchScene among(organs, 2);
  auto times = TimeInTurn({Cycle(&among), Cycle(alone)},
                          quick ? RepeatOptions{5, 200, 50} : RepeatOptions{5, 2000, 2000});
  for (std::vector<double>& of_one : times) {
    for (double& time : of_one) time /= 2;
  }
  HPDM_CHECK(among.AllPress() && alone->AllPress());
  // A single step of less than a microsecond is below the resolution of the thread's clock.
  constexpr int kMany = 100;
  const auto away = [&among] {
    for (int i = 0; i < kMany; ++i) among.StepAway();
  };
  Timing idle = Time(away, quick ? RepeatOptions{5, 50, 20} : RepeatOptions{5, 500, 300});
  idle.median_us /= kMany;
  idle.minimum_us /= kMany;
  return {.scene = "livers in a row",
          .sleeping = sleeping,
          .triangles = among.triangles(),
          .among = Summary(times[0]),
          .alone = Summary(times[1]),
          .ratio = RatioOf(times[0], times[1]),
          .idle_us = idle.median_us};
}

// A session's loops on the lockstep clock, with the scene's own hands.
class SteppedSession {
 public:
  explicit SteppedSession(Scene scene)
      : session_(std::move(scene)),
        haptics_(session_.HapticInstruments(), session_.haptic_period_ns(),
                 {session_.tool_states, session_.patches, session_.samples}),
        deformation_(session_.organs(), session_.DeformationTools(),
                     {session_.tool_states, session_.patches, *session_.render_scenes,
                      *session_.telemetry_scenes, &session_.steps}),
        clock_(session_.scene().timing, &haptics_, &deformation_) {
    session_.EnableForces(true);
  }
  ~SteppedSession() { session_.EnableForces(false); }

  // Advances to the next step and computes it. Returns the thread's time, us.
  double Step() {
    for (;;) {
      const double ran = ThreadMilliseconds();
      if (clock_.StepIfDue()) {
        const double us = 1000 * (ThreadMilliseconds() - ran);
        clock_.Tick();
        return us;
      }
      clock_.Tick();
      for (HapticSample sample; session_.samples.Pop(&sample);) {
      }
      for (StepSample step; session_.steps.Pop(&step);) {
      }
    }
  }
  int Awake() const {
    int count = 0;
    for (int o = 0; o < organ_count(); ++o) count += deformation_.organ(o).awake;
    return count;
  }
  int organ_count() const { return static_cast<int>(session_.organs().size()); }
  int triangles() const {
    Eigen::Index count = 0;
    for (const OrganModel& organ : session_.organs()) count += organ.rest().triangles.rows();
    return static_cast<int>(count);
  }

 private:
  Session session_;
  HapticLoop haptics_;
  DeformationLoop deformation_;
  Lockstep clock_;
};

// Times the scene as it is and with its first organ alone, moved by the same hands. Counts the
// steps in which that organ is touched.
SleepResults TimeScene(bool quick) {
  Scene scene = LoadScene(kStressScene);
  SteppedSession among(scene);
  scene.organs.resize(1);
  SteppedSession alone(std::move(scene));
  std::vector<double> among_us, alone_us;
  for (int step = 0; step < (quick ? 90 : 600); ++step) {
    const double of_all = among.Step(), of_one = alone.Step();
    HPDM_CHECK(among.Awake() == alone.Awake());
    if (alone.Awake() == 0) continue;
    among_us.push_back(of_all);
    alone_us.push_back(of_one);
  }
  return {.scene = std::filesystem::path(kStressScene).stem(),
          .sleeping = among.organ_count() - 1,
          .triangles = among.triangles(),
          .among = Summary(among_us),
          .alone = Summary(alone_us),
          .ratio = RatioOf(among_us, alone_us),
          .idle_us = {}};
}

}  // namespace

std::vector<SleepResults> TimeSleep(bool quick) {
  BenchOrgan liver = MakeBenchOrgan(quick ? "liver_1332" : "liver_5000");
  liver.options.lattice.cells = {6, 6, 6};
  liver.options.lattice.local.functions = 27;
  const BenchOrgan other = MakeBenchOrgan(quick ? "liver_274" : "liver_5000");
  BenchScene alone({liver}, 2);
  std::vector<SleepResults> rows;
  for (const int sleeping : quick ? std::vector{3} : std::vector{1, 3, 11}) {
    rows.push_back(TimeAmong(liver, other, sleeping, &alone, quick));
  }
  if (std::filesystem::exists(kStressScene)) rows.push_back(TimeScene(quick));
  return rows;
}

}  // namespace hpdm
