#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <semaphore>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/check.h"
#include "engine/deformation_loop.h"
#include "engine/threads/loop_schedule.h"
#include "engine/threads/realtime.h"
#include "haptics/device/switched_device.h"
#include "haptics/haptic_loop.h"
#include "tools/bench/bench_model.h"
#include "tools/bench/bench_results.h"
#include "tools/session/realtime_threads.h"

namespace hpdm {
namespace {

constexpr int kTools = 2;

constexpr Nanoseconds kPeriod = 1'000'000;
constexpr int kPoses = 1000;
constexpr double kFriction = 0.2;

// A device that follows a closed path, one pose per reading.
class PathDevice : public SwitchedDevice {
 public:
  explicit PathDevice(std::vector<JointVector> path) : path_(std::move(path)) {}

  DeviceSample Read(Nanoseconds now) noexcept override {
    const JointVector& joints = path_[reads_ % path_.size()];
    return {.sequence = ++reads_, .time_ns = now, .joints = joints, .valid = true};
  }
  void Write(const AxisEffort& effort) noexcept override { effort_ = effort; }
  DeviceLimits limits() const noexcept override { return LimitsOf({}); }

 private:
  std::vector<JointVector> path_;
  AxisEffort effort_ = AxisEffort::Zero();
  std::uint64_t reads_ = 0;
};

// The depth of a tip's centre below the front of the organ, m.
constexpr double kDepth = 0.005;

// A session's haptic and deformation loops, for a thread each. Two tools press 5 mm deep, and each
// slides back and forth by 3 mm, once a second. With two organs each, every tip lies between the
// first one and a copy of it, which leans outwards by 30 degrees and is pressed as deep.
class FeltScene {
 public:
  FeltScene(const BenchOrgan& organ, int organs)
      : organs_(Organs(organ, organs)),
        render_(SizedSnapshot(organs_, kTools, true)),
        telemetry_(SizedSnapshot(organs_, kTools, false)),
        deformation_(organs_, std::vector<ToolOptions>(kTools),
                     {tool_states_, patches_, render_, telemetry_}),
        haptics_(Instruments(), kPeriod, {tool_states_, patches_, samples_}) {}

  int triangles() const { return static_cast<int>(organs_[0].rest().triangles.rows()); }

  // Returns the wall time of one tick that is due now, ns.
  Nanoseconds Tick(std::uint64_t tick, LoopClock* clock) {
    haptics_.Tick(tick, clock->Now(), {.clock = clock});
    HapticSample sample;
    HPDM_CHECK(samples_.Pop(&sample));
    took_patch_ = sample.patch_tick == tick && sample.patch_number > 0;
    ticks_pressing_ +=
        sample.tools[0].kind == ContactKind::kPress && sample.tools[1].kind == ContactKind::kPress;
    return sample.compute_ns;
  }
  // Makes a step. The presses of its contacts must be as many as those of the scene.
  void Step(Nanoseconds now) {
    const ToolState tools = deformation_.NewestTools();
    presses_ = 0;
    for (const auto& contact_points : tools.contact_points) {
      for (const TickContactPoint& point : contact_points) presses_ += point.organ >= 0;
    }
    deformation_.Step(tools, now);
  }
  int presses() const { return presses_; }                // at the last step
  bool took_patch() const { return took_patch_; }         // by the last tick, a new one
  int ticks_pressing() const { return ticks_pressing_; }  // in which both tools press
  void ForgetPresses() { ticks_pressing_ = 0; }

 private:
  static constexpr std::array<double, kTools> kSides{-0.04, 0.05};  // m

  static std::vector<OrganModel> Organs(const BenchOrgan& organ, int organs_each) {
    std::vector<OrganModel> organs;
    organs.emplace_back(organ.options, organ.rest);
    if (organs_each == 1) return organs;
    for (const double side : kSides) {
      const Eigen::AngleAxisd leans(std::copysign(std::numbers::pi / 6, -side), Vector3d::UnitY());
      const Vector3d normal = leans * Vector3d::UnitZ();
      const Vector3d p =
          FrontPoint(organ.rest, side).Position(organ.rest.vertices, organ.rest.triangles);
      const Vector3d to = p - Vector3d(0, 0, kDepth) + kDepth * normal;
      SurfaceMesh rest = organ.rest;
      for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
        const Vector3d from_p = rest.vertices.row(v).transpose() - p;
        rest.vertices.row(v) = (to + leans * from_p).transpose();
      }
      organs.emplace_back(organ.options, rest);
    }
    return organs;
  }

  std::vector<HapticInstrument> Instruments() {
    std::vector<HapticInstrument> instruments;
    const SurfaceMesh& rest = organs_[0].rest();
    for (int i = 0; i < kTools; ++i) {
      const SurfacePoint at = FrontPoint(rest, kSides[static_cast<std::size_t>(i)]);
      const Vector3d p_W = at.Position(rest.vertices, rest.triangles);
      const ImpulseEngineKinematics kinematics(p_W + Vector3d(0, 0, 0.15), -Vector3d::UnitZ(),
                                               DeviceProfile{});
      std::vector<JointVector> path;
      for (int k = 0; k < kPoses; ++k) {
        const double slide = 0.0015 * std::sin(2 * std::numbers::pi * k / kPoses);
        path.push_back(kinematics.Inverse(p_W + Vector3d(slide, 0, -kDepth), 0, 1).joints);
      }
      devices_.push_back(std::make_unique<PathDevice>(std::move(path)));
      devices_.back()->Home();
      devices_.back()->EnableForce(true);
      instruments.push_back({.device = devices_.back().get(),
                             .kinematics = kinematics,
                             .geometries = {{.friction = kFriction}}});
    }
    return instruments;
  }

  std::vector<OrganModel> organs_;
  std::vector<std::unique_ptr<PathDevice>> devices_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> render_, telemetry_;
  SpscQueue<HapticSample> samples_{4};
  DeformationLoop deformation_;
  HapticLoop haptics_;
  bool took_patch_ = false;
  int ticks_pressing_ = 0;
  int presses_ = 0;
};

// Makes the steps in a thread of their own, as a session does. In the thread of the ticks a step
// would evict the ticks' own code and state from the core's caches.
class StepThread {
 public:
  StepThread(std::array<FeltScene*, 2> scenes, LoopClock* clock)
      : scenes_(scenes), clock_(clock), thread_([this](std::stop_token stop) { Run(stop); }) {}
  ~StepThread() {
    thread_.request_stop();
    wanted_.release();
  }

  // Wants a step of each scene, unless the last ones still run.
  void Want() {
    if (!busy_.exchange(true)) wanted_.release();
  }

 private:
  void Run(std::stop_token stop) {
    RequestRealtime(DeformationRealtime());
    for (wanted_.acquire(); !stop.stop_requested(); wanted_.acquire()) {
      for (FeltScene* scene : scenes_) scene->Step(clock_->Now());
      busy_ = false;
    }
  }

  std::array<FeltScene*, 2> scenes_;
  LoopClock* clock_;
  std::counting_semaphore<2> wanted_{0};
  std::atomic<bool> busy_ = false;
  std::jthread thread_;
};

// A chain of dependent arithmetic: the time of `rounds` does not depend on the state of the caches.
double BareLoop(int rounds) {
  volatile double start = 1.0;
  double x = start;
  for (int i = 0; i < rounds; ++i) x = x * 0.999999 + 1e-6;
  return x;
}

// Returns the rounds of the bare loop that take about `wanted` ns.
int RoundsFor(double wanted, LoopClock* clock) {
  constexpr int kRounds = 20000;
  Nanoseconds fastest = kNanosecondsPerSecond;
  volatile double sink = 0;
  for (int i = 0; i < 20; ++i) {
    const Nanoseconds start = clock->Now();
    sink = BareLoop(kRounds);
    fastest = std::min(fastest, clock->Now() - start);
  }
  static_cast<void>(sink);
  return static_cast<int>(std::lround(kRounds * wanted / static_cast<double>(fastest)));
}

double Median(std::vector<double>* values) {
  const auto middle = values->begin() + static_cast<std::ptrdiff_t>(values->size() / 2);
  std::nth_element(values->begin(), middle, values->end());
  return *middle;
}

// Runs a tick of each scene and the bare loop in turn in every period, so that a disturbance
// affects all.
class TickTimer {
 public:
  TickTimer(FeltScene* coarse, FeltScene* fine) : scenes_{coarse, fine}, steps_(scenes_, &clock_) {}

  TickResults Run(int ticks) {
    TickResults results;
    for (int i = 0; i < kRampTicks; ++i) OnePeriod(i, &results);
    bare_rounds_ = RoundsFor(static_cast<double>(results.coarse.Percentile(0.5)), &clock_);
    results = TickResults();
    for (FeltScene* scene : scenes_) scene->ForgetPresses();
    std::vector<double> coarse, fine;  // medians of blocks
    for (int i = 0; i < ticks; ++i) {
      OnePeriod(i, &results);
      if (i % kBlock < kBlock - 1) continue;
      coarse.push_back(Median(&blocks_[0]));
      fine.push_back(Median(&blocks_[1]));
      for (std::vector<double>& block : blocks_) block.clear();
    }
    for (FeltScene* scene : scenes_) HPDM_CHECK(scene->ticks_pressing() == ticks);
    results.coarse_triangles = scenes_[0]->triangles();
    results.fine_triangles = scenes_[1]->triangles();
    results.ratio = RatioOf(fine, coarse);
    return results;
  }

 private:
  static constexpr int kRampTicks = 660;  // the force ramp-in and the first steps
  static constexpr int kBlock = 100;      // ticks per ratio
  static constexpr int kTicksAStep = 33;

  void OnePeriod(int number, TickResults* results) {
    clock_.SleepUntil(wake_);
    std::array<Nanoseconds, 2> took;
    // The first to run finds colder caches, so the order alternates.
    for (const int i : {number % 2, 1 - number % 2}) took[i] = scenes_[i]->Tick(tick_, &clock_);
    results->coarse.Add(took[0]);
    results->fine.Add(took[1]);
    for (int i = 0; i < 2; ++i) {
      if (scenes_[i]->took_patch()) results->with_new_patch.Add(took[i]);
      blocks_[i].push_back(static_cast<double>(took[i]));
    }
    const Nanoseconds start = clock_.Now();
    result_ = BareLoop(bare_rounds_);
    results->bare.Add(clock_.Now() - start);
    if (number % kTicksAStep == kTicksAStep - 1) steps_.Want();
    ++tick_;
    wake_ = std::max(wake_ + kPeriod, clock_.Now());
  }

  std::array<FeltScene*, 2> scenes_;
  RealLoopClock clock_{SessionClock()};
  StepThread steps_;
  Nanoseconds wake_ = 0;
  std::uint64_t tick_ = 0;
  int bare_rounds_ = 0;
  volatile double result_ = 0;
  std::array<std::vector<double>, 2> blocks_;
};

}  // namespace

std::vector<TickResults> TimeTicks(bool quick) {
  BenchOrgan coarse = MakeBenchOrgan("liver_274");
  BenchOrgan fine = MakeBenchOrgan(quick ? "liver_5000" : "liver_120000");
  for (BenchOrgan* organ : {&coarse, &fine}) organ->options.lattice.cells = {6, 6, 6};
  std::vector<TickResults> rows;
  for (const int organs : {1, 2}) {
    FeltScene coarse_scene(coarse, organs), fine_scene(fine, organs);
    std::jthread([&] {
      RealtimeOptions realtime = HapticRealtime();
      realtime.lock_memory = true;
      RequestRealtime(realtime);
      rows.push_back(TickTimer(&coarse_scene, &fine_scene).Run(quick ? 1000 : 20000));
    }).join();
    rows.back().organs = organs;
    for (const FeltScene* scene : {&coarse_scene, &fine_scene}) {
      HPDM_CHECK(scene->presses() >= organs * kTools);
    }
  }
  return rows;
}

}  // namespace hpdm
