#include "tools/session/session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/error.h"
#include "render/overlay/overlay_renderer.h"
#include "tools/session/session_devices.h"
#include "tools/shared/report_text.h"
#include "tools/shared/static_case.h"

namespace hpdm {
namespace {

// A quarter of the reference's largest displacement, so that errors of a few per cent are visible.
double ErrorScale(const Points& reference) {
  return RoundedUp(reference.rowwise().norm().maxCoeff() / 4);
}

}  // namespace

Session::Session(Scene scene, std::vector<DeviceChoice> devices, const Progress& progress)
    : samples(2 * static_cast<std::size_t>(scene.timing.haptic_hz)),
      steps(2 * static_cast<std::size_t>(scene.timing.deformation_hz)),
      external_forces(64),
      frames(2 * static_cast<std::size_t>(std::ceil(scene.timing.render_hz)) + 1),
      choices_(std::move(devices)) {
  HPDM_CHECK(choices_.size() == scene.instruments.size());
  // Before the slow steps, so that a bad one is reported at once.
  const std::vector<TraceFile> traces = ReadTraces(choices_);
  model_ = std::make_shared<const SessionModel>(std::move(scene), progress);
  remarks_ = model_->remarks();
  references_.assign(organs().size(), Points(0, 3));
  MakeDevices(traces);
  const int tools = static_cast<int>(choices_.size());
  render_scenes = std::make_unique<TripleBuffer<SceneSnapshot>>(
      SizedSnapshot(organs(), tools, true, beds(), ducts()));
  telemetry_scenes =
      std::make_unique<TripleBuffer<SceneSnapshot>>(SizedSnapshot(organs(), tools, false));
}

void Session::MakeDevices(const std::vector<TraceFile>& traces) {
  bool all_traces = true;
  for (std::size_t i = 0; i < choices_.size(); ++i) {
    const InstrumentOptions& instrument = scene().instruments[i];
    SessionDevice made = MakeSessionDevice(*model_, i, choices_[i], traces[i]);
    external_readings[i] = made.readings;
    hand_targets[i] = made.hand_targets;
    trace_length_ = std::max(trace_length_, made.duration);
    all_traces = all_traces && choices_[i].type == DeviceChoice::Type::kTrace;
    if (!made.remark.empty()) remarks_.push_back(made.remark);
    devices_.push_back(std::move(made.device));
    if (!walls().empty() && choices_[i].type == DeviceChoice::Type::kLcm &&
        instrument.device.delay == 0) {
      remarks_.push_back(
          "instrument \"" + instrument.name +
          "\": the stiffness of rigid organs is for a device without delay; give the "
          "driver's delay as instrument.device.delay");
    }
  }
  if (!all_traces) trace_length_ = 0;
}

bool Session::HasExternalDevice() const {
  return std::any_of(external_readings.begin(), external_readings.end(),
                     [](const auto* readings) { return readings != nullptr; });
}

void Session::EnableForces(bool on) {
  for (const std::unique_ptr<Device>& device : devices_) {
    if (on) device->Home();
    device->EnableForce(on);
  }
}

void Session::LoadReference(const std::string& argument) {
  const auto named = std::find_if(organs().begin(), organs().end(), [&](const OrganModel& organ) {
    return argument.starts_with(organ.options().name + "=");
  });
  if (named == organs().end() && organs().size() != 1) {
    throw InputError("--reference " + argument + ": the scene has " +
                     std::to_string(organs().size()) + " organs; name one, as in " +
                     organs()[0].options().name + "=FILE");
  }
  const auto organ =
      static_cast<std::size_t>(named == organs().end() ? 0 : named - organs().begin());
  const std::string file =
      named == organs().end() ? argument : argument.substr(named->options().name.size() + 1);
  references_[organ] = ReadReferenceDisplacements(file, organs()[organ].rest());
  remarks_.push_back(Format("organ \"%s\": error overlay from 0 to %g mm against %s",
                            organs()[organ].options().name.c_str(),
                            1000 * ErrorScale(references_[organ]), file.c_str()));
}

std::vector<OrganVisual> Session::OrganVisuals() const {
  std::vector<OrganVisual> visuals = model_->OrganVisuals();
  for (std::size_t i = 0; i < visuals.size(); ++i) {
    if (references_[i].rows() == 0) continue;
    visuals[i].reference = &references_[i];
    visuals[i].error_scale = ErrorScale(references_[i]);
  }
  return visuals;
}

std::vector<TrainerInput::Instrument> Session::TrainerInstruments() const {
  std::vector<TrainerInput::Instrument> instruments(scene().instruments.size());
  for (std::size_t i = 0; i < instruments.size(); ++i) {
    instruments[i].exchanges = scene().instruments[i].HeldCount();
    if (hand_targets[i] == nullptr) continue;
    instruments[i].mouse = model_->kinematics(i);
    instruments[i].start = hand_targets[i]->Front();
  }
  return instruments;
}

}  // namespace hpdm
