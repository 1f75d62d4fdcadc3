#include "tools/python/native/python_session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/session/command_device.h"

namespace hpdm {

SharedPictures::~SharedPictures() {
  // In a forked child the thread does not exist: nothing can be joined.
  if (pictures_ != nullptr && !process_->SameProcess()) static_cast<void>(pictures_.release());
}

void SharedPictures::Draw(const LockstepSession& session, const PictureWish& wish,
                          SessionPicture* picture) {
  {
    const std::lock_guard lock(mutex_);
    if (pictures_ == nullptr) {
      pictures_ = std::make_unique<SessionPictures>(model_);
      process_ = std::make_unique<ProcessCheck>();
    }
    process_->Require("the threads that draw pictures");
  }
  pictures_->Draw(session, wish, picture);
}

SessionData::SessionData(std::shared_ptr<const SessionModel> model,
                         std::vector<DeviceChoice> devices, std::uint32_t seed,
                         CommandKind command_kind)
    : kind(command_kind),
      session(model, std::move(devices), seed),
      commands(kAxes * session.devices().size()),
      displacements(model->organs().size(), Points(0, 3)),
      pictures(std::make_shared<SharedPictures>(model)) {
  FillCommands();
}

SessionData::SessionData(const SessionData& other)
    : kind(other.kind),
      session(other.session),
      commands(other.commands),
      displacements(other.displacements.size(), Points(0, 3)),
      pictures(other.pictures) {}

void SessionData::ApplyCommands() {
  const std::vector<DeviceChoice>& devices = session.devices();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    if (devices[i].type != DeviceChoice::Type::kCommand) continue;
    const Eigen::Map<const JointVector> command(commands.data() + kAxes * i);
    if (!command.allFinite()) {
      FailValue("command[\"" + session.model().scene().instruments[i].name +
                "\"] has a value that is not finite");
    }
    if (kind == CommandKind::kAxes) {
      session.Command(i, command);
    } else {
      session.Command(
          i,
          session.model().kinematics(i).Inverse(command.head<3>(), command[3], command[4]).joints);
    }
  }
}

void SessionData::Step() {
  session.Step();
  Refresh();
}

void SessionData::Reset(std::uint32_t seed) {
  session.Reset(seed);
  FillCommands();
  Refresh();
}

void SessionData::Load(const SessionData& state) {
  session = state.session;
  commands = state.commands;
  Refresh();
}

void SessionData::Refresh() {
  for (std::size_t o = 0; o < displacements.size(); ++o) {
    if (displacements[o].rows() == 0) continue;
    displacements[o] = session.organ(o).vertices - session.model().organs()[o].rest().vertices;
  }
}

const Points& SessionData::Displacements(std::size_t organ) {
  Points& field = displacements[organ];
  if (field.rows() == 0) {
    field = session.organ(organ).vertices - session.model().organs()[organ].rest().vertices;
  }
  return field;
}

// The tools' present places: an untouched command keeps them.
void SessionData::FillCommands() {
  for (std::size_t i = 0; i < session.devices().size(); ++i) {
    const ToolView& tool = session.tools()[i];
    double* command = commands.data() + kAxes * i;
    std::copy(tool.joints.begin(), tool.joints.end(), command);
    if (kind == CommandKind::kTip) std::copy(tool.tip.begin(), tool.tip.end(), command);
  }
}

BatchData::BatchData(std::shared_ptr<const SessionModel> model, std::vector<DeviceChoice> devices,
                     const std::vector<std::uint32_t>& seeds, CommandKind kind, int threads)
    : pool_(std::make_unique<WorkerPool>(threads)) {
  sessions_.push_back(std::make_unique<SessionData>(model, std::move(devices), seeds[0], kind));
  sessions_.resize(seeds.size());
  pool_->ForEach(count() - 1, [&](int i) {
    const auto s = static_cast<std::size_t>(i) + 1;
    sessions_[s] = std::make_unique<SessionData>(*sessions_[0]);
    sessions_[s]->Reset(seeds[s]);
  });
  const std::size_t sessions = seeds.size();
  commands.resize(sessions * tools() * SessionData::kAxes);
  views.resize(sessions * tools());
  organ_forces.resize(3 * sessions * organs());
  for (int i = 0; i < count(); ++i) {
    Collect(i);
    TakeCommands(i);
  }
}

BatchData::~BatchData() {
  // In a forked child the threads do not exist: they cannot be joined.
  if (!process_.SameProcess() && pool_->threads() > 1) static_cast<void>(pool_.release());
}

void BatchData::Collect(int index) {
  const auto i = static_cast<std::size_t>(index);
  const LockstepSession& session = at(index).session;
  std::copy(session.tools().begin(), session.tools().end(),
            views.begin() + static_cast<std::ptrdiff_t>(i * tools()));
  std::copy(session.organ_forces().begin(), session.organ_forces().end(),
            organ_forces.begin() + static_cast<std::ptrdiff_t>(i * 3 * organs()));
}

void BatchData::TakeCommands(int index) {
  const std::vector<double>& own = at(index).commands;
  std::copy(
      own.begin(), own.end(),
      commands.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(index) * own.size()));
}

void BatchData::Step() {
  if (pool_->threads() > 1) process_.Require("the batch's threads");
  for (const double value : commands) {
    if (!std::isfinite(value)) FailValue("command has a value that is not finite");
  }
  pool_->ForEach(count(), [this](int index) {
    SessionData& data = at(index);
    const std::size_t size = data.commands.size();
    const auto from =
        commands.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(index) * size);
    std::copy(from, from + static_cast<std::ptrdiff_t>(size), data.commands.begin());
    data.ApplyCommands();
    data.Step();
    Collect(index);
  });
}

void BatchData::Reset(const std::vector<int>& which, const std::vector<std::uint32_t>& seeds) {
  if (pool_->threads() > 1) process_.Require("the batch's threads");
  pool_->ForEach(static_cast<int>(which.size()), [&](int w) {
    const auto i = static_cast<std::size_t>(w);
    at(which[i]).Reset(seeds[i]);
    Collect(which[i]);
    TakeCommands(which[i]);
  });
}

void BatchData::Load(int index, const SessionData& state) {
  at(index).Load(state);
  Collect(index);
  TakeCommands(index);
}

}  // namespace hpdm
