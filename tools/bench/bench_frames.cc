#include <time.h>

#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "haptics/haptic_loop.h"
#include "render/camera/picture_target.h"
#include "render/gl/egl_context.h"
#include "render/scene_renderer.h"
#include "tools/bench/bench_results.h"
#include "tools/session/lockstep.h"
#include "tools/session/session.h"

namespace hpdm {
namespace {

constexpr std::array kScenes = {"scenes/liver_palpation.toml", "scenes/two_hands.toml",
                                "scenes/abdomen_on_springs.toml", "scenes/stress.toml"};
constexpr std::array<std::pair<int, int>, 2> kSizes = {{{640, 480}, {1280, 720}}};

// Returns the snapshots that a session would draw in its first `seconds`.
std::vector<SceneSnapshot> Snapshots(Session* session, double seconds) {
  HapticLoop haptics(session->HapticInstruments(), session->haptic_period_ns(),
                     {session->tool_states, session->patches, session->samples});
  DeformationLoop deformation(session->organs(), session->DeformationTools(),
                              {session->tool_states, session->patches, *session->render_scenes,
                               *session->telemetry_scenes, &session->steps});
  const TimingOptions& timing = session->scene().timing;
  Lockstep clock(timing, &haptics, &deformation);
  std::vector<SceneSnapshot> snapshots;
  session->EnableForces(true);
  while (static_cast<double>(clock.tick()) < seconds * timing.haptic_hz) {
    if (clock.StepIfDue() && session->render_scenes->Update()) {
      snapshots.push_back(session->render_scenes->Front());
    }
    clock.Tick();
    HapticSample sample;
    while (session->samples.Pop(&sample)) {
    }
    StepSample step;
    while (session->steps.Pop(&step)) {
    }
  }
  session->EnableForces(false);
  return snapshots;
}

// Returns the CPU time of all threads of the process so far, ns.
Nanoseconds CoreTime() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

// One way to draw the pictures.
struct Way {
  std::string name;
  int samples = 0;  // per pixel, as for PictureTarget
  SceneRendererOptions view;
  double distortion = 0;
};

std::vector<Way> Ways() {
  return {{.name = "as in a session", .view = {}},
          {.name = "without occlusion", .view = {.occlusion = false}},
          {.name = "without the instruments' shadow", .view = {.shadows = false}},
          {.name = "every triangle", .view = {.levels = false}},
          {.name = "four samples a pixel", .samples = 4, .view = {}},
          {.name = "with distortion -0.15", .view = {}, .distortion = -0.15}};
}

class Drawing {
 public:
  Drawing(const Way& way, const Session& session, int width, int height)
      : scope_(WithDistortion(session.scene().laparoscope, way.distortion), width, height),
        target_(width, height, way.samples),
        view_(session.OrganVisuals(), session.InstrumentVisuals(), session.Background(), way.view) {
  }

  // Draws the snapshot and reads the picture back.
  void Frame(const SceneSnapshot& snapshot) {
    target_.Bind();
    view_.Draw(snapshot, scope_);
    target_.Resolve(scope_);
    target_.Read(&image_);
  }

 private:
  static LaparoscopeOptions WithDistortion(LaparoscopeOptions options, double distortion) {
    options.distortion = distortion;
    return options;
  }

  Laparoscope scope_;
  PictureTarget target_;
  SceneRenderer view_;
  Image image_;
};

int TriangleCount(const Session& session) {
  Eigen::Index count = 0;
  for (const OrganModel& organ : session.organs()) count += organ.rest().triangles.rows();
  return static_cast<int>(count);
}

// Draws with all ways in turn, so that a temporary slowdown of the machine affects all of them.
void TimeScene(const std::string& scene, bool quick, std::vector<FrameResults>* results) {
  Session session(LoadScene(scene));
  const std::vector<SceneSnapshot> snapshots = Snapshots(&session, quick ? 1 : 3);
  const EglContext context;
  for (const auto& [width, height] : kSizes) {
    std::vector<std::unique_ptr<Drawing>> drawings;
    std::vector<FrameResults> rows;
    for (const Way& way : Ways()) {
      drawings.push_back(std::make_unique<Drawing>(way, session, width, height));
      // Drivers finish compiling their shaders at the first use.
      drawings.back()->Frame(snapshots.front());
      rows.push_back({.scene = std::filesystem::path(scene).stem(),
                      .triangles = TriangleCount(session),
                      .width = width,
                      .height = height,
                      .way = way.name,
                      .frame = {},
                      .cores = {}});
    }
    for (const SceneSnapshot& snapshot : snapshots) {
      for (std::size_t i = 0; i < drawings.size(); ++i) {
        const Nanoseconds on_cores = CoreTime();
        const TimingClock::time_point start = TimingClock::now();
        drawings[i]->Frame(snapshot);
        rows[i].frame.Add(std::chrono::nanoseconds(TimingClock::now() - start).count());
        rows[i].cores.Add(CoreTime() - on_cores);
      }
    }
    results->insert(results->end(), rows.begin(), rows.end());
  }
}

}  // namespace

std::vector<FrameResults> TimeFrames(bool quick) {
  std::vector<FrameResults> results;
  for (const char* scene : kScenes) {
    if (std::filesystem::exists(scene)) TimeScene(scene, quick, &results);
  }
  return results;
}

}  // namespace hpdm
