#include "tools/session/lockstep_session.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"
#include "lcmtypes/telemetry/exercise_events.h"
#include "tools/session/command_device.h"
#include "tools/session/session_recorder.h"

namespace hpdm {
namespace {

std::vector<std::unique_ptr<Device>> MakeAll(const SessionModel& model,
                                             const std::vector<DeviceChoice>& choices,
                                             const std::vector<TraceFile>& traces,
                                             std::uint32_t seed) {
  std::vector<std::unique_ptr<Device>> devices;
  for (std::size_t i = 0; i < choices.size(); ++i) {
    devices.push_back(MakeSessionDevice(model, i, choices[i], traces[i], seed).device);
    devices.back()->Home();
    devices.back()->EnableForce(true);
  }
  return devices;
}

std::vector<std::unique_ptr<Device>> Copies(const std::vector<std::unique_ptr<Device>>& devices) {
  std::vector<std::unique_ptr<Device>> copies;
  for (const std::unique_ptr<Device>& device : devices) copies.push_back(device->Clone());
  return copies;
}

std::array<double, 3> Numbers(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

LockstepSession::LockstepSession(std::shared_ptr<const SessionModel> model,
                                 std::vector<DeviceChoice> devices, std::uint32_t seed)
    : model_(std::move(model)),
      choices_(std::move(devices)),
      traces_(std::make_shared<const std::vector<TraceFile>>(ReadTraces(choices_))),
      devices_(MakeAll(*model_, choices_, *traces_, seed)),
      haptics_(model_->HapticInstruments(devices_), model_->haptic_period_ns(), HapticEdges()),
      deformation_(model_->organs(), model_->DeformationTools(), StepEdges(), nullptr, 0,
                   model_->scene().attachments, model_->scene().ducts),
      clock_(model_->scene().timing, &haptics_, &deformation_),
      tools_(choices_.size()),
      organ_forces_(3 * model_->organs().size()),
      reporter_(model_->Info(), nullptr, nullptr) {
  if (model_->scene().exercise) exercise_.emplace(*model_->scene().exercise);
  AttachLoops();
  ObserveStart();
  start_ = std::make_shared<const LockstepSession>(*this);
}

LockstepSession::LockstepSession(const LockstepSession& other)
    : model_(other.model_),
      choices_(other.choices_),
      traces_(other.traces_),
      start_(other.start_),
      devices_(Copies(other.devices_)),
      haptics_(other.haptics_),
      deformation_(other.deformation_),
      clock_(other.clock_),
      steps_(other.steps_),
      sample_(other.sample_),
      tick_forces_(other.tick_forces_),
      tools_(other.tools_),
      organ_forces_(other.organ_forces_),
      reporter_(other.reporter_),
      exercise_(other.exercise_),
      events_(other.events_) {
  CopyEdges(other);
  AttachLoops();
}

LockstepSession& LockstepSession::operator=(const LockstepSession& other) {
  if (this == &other) return *this;
  HPDM_CHECK(Fits(other));
  model_ = other.model_;
  choices_ = other.choices_;
  traces_ = other.traces_;
  if (other.start_ != nullptr) start_ = other.start_;
  devices_ = Copies(other.devices_);
  haptics_ = other.haptics_;
  deformation_ = other.deformation_;
  clock_ = other.clock_;
  steps_ = other.steps_;
  sample_ = other.sample_;
  tick_forces_ = other.tick_forces_;
  tools_ = other.tools_;
  organ_forces_ = other.organ_forces_;
  reporter_ = other.reporter_;
  exercise_ = other.exercise_;
  events_ = other.events_;
  recorder_ = nullptr;
  checkpoints_ = nullptr;
  CopyEdges(other);
  AttachLoops();
  return *this;
}

bool LockstepSession::Fits(const LockstepSession& other) const {
  if (other.choices_.size() != choices_.size()) return false;
  if (other.model_->organs().size() != model_->organs().size()) return false;
  for (std::size_t o = 0; o < model_->organs().size(); ++o) {
    const OrganState &own = organ(o), &their = other.organ(o);
    if (own.vertices.rows() != their.vertices.rows() ||
        own.control_displacements.rows() != their.control_displacements.rows()) {
      return false;
    }
  }
  return true;
}

void LockstepSession::CopyEdges(const LockstepSession& other) {
  tool_states_.Back() = other.tool_states_.Front();
  control_.Back() = other.control_.Front();
  // Patches of tools that the scene lacks are never written.
  ContactPatch& patch = patches_.Back();
  const ContactPatch& from = other.patches_.Front();
  patch.step = from.step;
  patch.tool_count = from.tool_count;
  for (std::size_t t = 0; t < choices_.size(); ++t) patch.tools[t] = from.tools[t];
}

void LockstepSession::AttachLoops() {
  haptics_.Attach(devices_, HapticEdges());
  deformation_.Attach(StepEdges());
  clock_.Attach(&haptics_, &deformation_);
  reporter_.SetSink(
      [this](EventSeverity severity, const std::string& name, const std::string& text) {
        events_.push_back({sample_.time_ns, severity, name, text});
        if (exercise_) AddExerciseEvent(sample_.time_ns, name, text, &*exercise_);
      });
}

HapticLoop::Edges LockstepSession::HapticEdges() {
  return {tool_states_, patches_, samples_, nullptr, &control_};
}

DeformationEdges LockstepSession::StepEdges() {
  return {tool_states_,   patches_,
          nobody_,        recorder_ == nullptr ? nobody_ : recorder_->scenes(),
          &step_samples_, checkpoints_.get()};
}

void LockstepSession::RecordTo(SessionRecorder* recorder) {
  recorder_ = recorder;
  deformation_.Attach(StepEdges());
}

void LockstepSession::Reset(std::uint32_t seed) {
  *this = *start_;
  MakeDevices(seed);
  ObserveStart();
}

void LockstepSession::MakeDevices(std::uint32_t seed) {
  devices_ = MakeAll(*model_, choices_, *traces_, seed);
  AttachLoops();
}

void LockstepSession::SetYoung(std::size_t organ, double young, std::uint32_t seed) {
  const LockstepSession start(model_->WithYoung(organ, young), choices_, seed);
  *this = start;
}

void LockstepSession::Command(std::size_t instrument, const JointVector& joints) {
  auto* device = dynamic_cast<CommandDevice*>(devices_[instrument].get());
  HPDM_CHECK(device != nullptr);
  const auto ticks = clock_.BeginOf(steps_ + 1) - clock_.BeginOf(steps_);
  // The last of the step's ticks is at the command. The one before the first was at the last one.
  device->MoveTo(joints, time_ns() - model_->haptic_period_ns(),
                 static_cast<Nanoseconds>(ticks) * model_->haptic_period_ns());
}

void LockstepSession::Exchange(std::size_t instrument, int instrument_index) {
  control_.Back() = control_.Front();
  control_.Back().instrument_index[instrument] = instrument_index;
  control_.Publish();
}

void LockstepSession::Press(std::size_t instrument, bool pressed) {
  control_.Back() = control_.Front();
  control_.Back().pedal[instrument] = pressed;
  control_.Publish();
}

void LockstepSession::KeepSteps() {
  HPDM_CHECK(exercise_.has_value());
  checkpoints_ = std::make_unique<Checkpoints>(exercise_->options().steps.size());
  deformation_.Attach(StepEdges());
  checkpoints_->MakeRoom(deformation_);
}

void LockstepSession::Restart(int step) {
  control_.Back() = control_.Front();
  RestartRequest& restart = control_.Back().restart;
  restart = {restart.count + 1, step};
  control_.Publish();
}

void LockstepSession::Step() {
  tick_forces_.clear();
  for (ToolView& tool : tools_) {
    tool.step_force = {};
    tool.peak_force = 0;
  }
  const std::uint64_t end = clock_.BeginOf(++steps_);
  const double share = 1.0 / static_cast<double>(end - clock_.tick());
  while (clock_.tick() < end) {
    // A log's queue holds two seconds of samples, and steps may be rarer.
    const auto second = static_cast<std::uint64_t>(model_->scene().timing.haptic_hz);
    if (recorder_ != nullptr && clock_.tick() % second == 0) recorder_->Drain();
    StepIfDue();
    clock_.Tick();
    samples_.Pop(&sample_);
    reporter_.Add(sample_);
    if (recorder_ != nullptr) recorder_->Add(sample_);
    for (std::size_t t = 0; t < tools_.size(); ++t) {
      const Vector3d& force_W = sample_.tools[t].force_W;
      for (int d = 0; d < 3; ++d) {
        tick_forces_.push_back(force_W[d]);
        tools_[t].step_force[static_cast<std::size_t>(d)] += share * force_W[d];
      }
      tools_[t].peak_force = std::max(tools_[t].peak_force, force_W.norm());
    }
  }
  Observe();
}

void LockstepSession::StepIfDue() {
  if (!clock_.StepIfDue()) return;
  StepSample step;
  while (step_samples_.Pop(&step)) {
    reporter_.Add(step);
    if (exercise_) {
      exercise_->Add(step);
      reporter_.Add(*exercise_);
      if (checkpoints_ != nullptr) {
        checkpoints_->progress().Back() = exercise_->Progress();
        checkpoints_->progress().Publish();
      }
    }
    if (recorder_ != nullptr) recorder_->Add(step);
  }
  if (recorder_ != nullptr) recorder_->Drain();
}

void LockstepSession::Observe() {
  std::fill(organ_forces_.begin(), organ_forces_.end(), 0);
  for (std::size_t t = 0; t < tools_.size(); ++t) {
    const ToolSample& sample = sample_.tools[t];
    ToolView& view = tools_[t];
    view.force = Numbers(sample.force_W);
    view.tip = Numbers(sample.p_tip_W);
    view.velocity = Numbers(sample.v_tip_W);
    const Eigen::Quaterniond rotation(model_->kinematics(t).Forward(sample.joints).linear());
    view.rotation = {rotation.x(), rotation.y(), rotation.z(), rotation.w()};
    std::copy_n(sample.joints.data(), view.joints.size(), view.joints.begin());
    view.jaw = sample.joints[kJaw];
    view.depth = sample.depth;
    view.slip = sample.slip;
    view.organ = sample.organ;
    view.kind = static_cast<std::int32_t>(sample.kind);
    for (int p = 0; p < kToolPlaces; ++p) {
      const HapticForce& place = haptics_.contacts(t).result(p);
      if (place.organ < 0) continue;
      for (int d = 0; d < 3; ++d) {
        organ_forces_[3 * static_cast<std::size_t>(place.organ) + static_cast<std::size_t>(d)] -=
            place.reaction_W[d];
      }
    }
  }
}

// Before the first tick the tools stand where their devices start.
void LockstepSession::ObserveStart() {
  const std::vector<std::unique_ptr<Device>> copies = Copies(devices_);
  for (std::size_t t = 0; t < copies.size(); ++t) {
    ToolSample& sample = sample_.tools[t];
    sample.joints = copies[t]->Read(0).joints;
    sample.p_tip_W = model_->kinematics(t).Forward(sample.joints).translation();
  }
  Observe();
}

}  // namespace hpdm
