#include "tools/session/session_recorder.h"

#include "engine/base/error.h"
#include "engine/deformation_loop.h"
#include "tools/session/session_path.h"

namespace hpdm {
namespace {

// The folder keeps the scene's file, and a replay builds its organs from that.
const Scene& RecordableScene(const SessionModel& model) {
  if (!model.IsOfSceneFile()) {
    throw InputError(
        "record: an organ's stiffness was set in the program, and a replay would not know it; give "
        "organ.material.young in the scene instead");
  }
  return model.scene();
}

TelemetryOptions RecordOptions(const SessionModel& model, const SessionFolder& folder, bool live) {
  TelemetryOptions options;
  options.live = live;
  options.timeline_path = folder.File("timeline.csv");
  options.haptic_period = model.haptic_period_ns();
  return options;
}

}  // namespace

SessionRecorder::SessionRecorder(const SessionModel& model, const std::filesystem::path& folder,
                                 bool live)
    : folder_(folder, RecordableScene(model)),
      samples_(2 * static_cast<std::size_t>(model.scene().timing.haptic_hz)),
      steps_(2 * static_cast<std::size_t>(model.scene().timing.deformation_hz)),
      scenes_(SizedSnapshot(model.organs(), static_cast<int>(model.scene().instruments.size()),
                            false)) {
  try {
    telemetry_.emplace(&samples_, &steps_, &scenes_, folder_.File(kSessionLogName),
                       RecordOptions(model, folder_, live), model.Info());
  } catch (...) {
    folder_.Discard();
    throw;
  }
}

std::string SessionRecorder::Finish() {
  telemetry_->Finish();
  folder_.Finish();
  const TelemetrySummary summary = telemetry_->Summary();
  if (summary.log.failure != LogFailure::kNone) return summary.log.Explain();
  return summary.timeline_failure;
}

}  // namespace hpdm
