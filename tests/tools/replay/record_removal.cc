// Records the scripted surgeon (tests/support/removal_surgeon.h) as a session, at the scene's own lattices:
//
//   ninja -C build record_removal
//   build/tests/record_removal scenes/gallbladder_removal.toml out/removal
//   build/tools/hpdm replay out/removal --film removal.mp4
//
// Prints the steps and errors, and how long the session's steps took. Exit status 1 unless all is done
// without an error; 2 on wrong input.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "scenes/loader/scene.h"
#include "tests/support/removal_surgeon.h"
#include "tools/session/session_recorder.h"

namespace {

int Record(const std::string& path, const std::string& folder) {
  using namespace hpdm;
  const auto model = std::make_shared<const SessionModel>(LoadScene(path));
  DeviceChoice command;
  command.type = DeviceChoice::Type::kCommand;
  LockstepSession session(model, {command, command});
  SessionRecorder recorder(*model, folder, false);
  session.RecordTo(&recorder);
  RemovalSurgeon surgeon(&session);
  const auto started = std::chrono::steady_clock::now();
  const std::size_t done = surgeon.Operate();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - started;
  session.RecordTo(nullptr);
  const std::string failure = recorder.Finish();
  if (!failure.empty()) std::fprintf(stderr, "record_removal: %s\n", failure.c_str());

  const ExerciseOptions& exercise = session.exercise()->options();
  const ExerciseResult& result = surgeon.result();
  for (std::size_t s = 0; s < done; ++s) {
    std::printf("%8.2f s  %s\n", result.step_times[s], exercise.steps[s].name.c_str());
  }
  for (const ExerciseError& error : result.errors) {
    std::printf("%8.2f s  error: %s\n", error.time,
                exercise.errors[ToSize(error.rule)].name.c_str());
  }
  std::vector<Nanoseconds> times = surgeon.step_times();
  std::ranges::sort(times);
  const auto quantile = [&times](double share) {
    return 1e-6 *
           static_cast<double>(
               times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))]);
  };
  std::printf(
      "processor time of a step with its ticks and log: %.1f ms median, %.1f p99, %.1f most\n",
      quantile(0.5), quantile(0.99), quantile(1));
  std::printf("%zu of %zu steps, score %.0f, computed in %.0f s\n", done, exercise.steps.size(),
              result.score, took.count());
  return done == exercise.steps.size() && result.errors.empty() && failure.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: record_removal SCENE FOLDER\n");
    return 2;
  }
  try {
    return Record(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "record_removal: %s\n", error.what());
    return 2;
  }
}
