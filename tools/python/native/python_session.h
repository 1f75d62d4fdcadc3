#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "tools/python/native/python_errors.h"
#include "tools/python/native/session_pictures.h"
#include "tools/python/native/worker_pool.h"
#include "tools/session/lockstep_session.h"

namespace hpdm {

/// How commands are given: the device's axes, or x, y, z of the tip (m), roll and jaw.
enum class CommandKind { kAxes, kTip };

/// The pictures of all sessions of a model; made with the first picture.
class SharedPictures {
 public:
  explicit SharedPictures(std::shared_ptr<const SessionModel> model) : model_(std::move(model)) {}
  ~SharedPictures();
  void Draw(const LockstepSession& session, const PictureWish& wish, SessionPicture* picture);

 private:
  std::shared_ptr<const SessionModel> model_;
  std::mutex mutex_;
  std::unique_ptr<SessionPictures> pictures_;
  std::unique_ptr<ProcessCheck> process_;
};

/// One session with what Python writes into and reads from it. Arrays stay in place.
struct SessionData {
  static constexpr std::size_t kAxes = 5;

  SessionData(std::shared_ptr<const SessionModel> model, std::vector<DeviceChoice> devices,
              std::uint32_t seed, CommandKind command_kind);
  SessionData(const SessionData& other);
  SessionData& operator=(const SessionData&) = delete;

  /// Throws ValueError if a command is not finite; otherwise passes all on to the devices.
  void ApplyCommands();
  /// Computes a step. Without Python's lock.
  void Step();
  void Reset(std::uint32_t seed);
  void Load(const SessionData& state);
  /// After the state was replaced.
  void Refresh();
  void FillCommands();
  const Points& Displacements(std::size_t organ);

  CommandKind kind;
  LockstepSession session;
  std::vector<double> commands;       // instruments x 5
  std::vector<Points> displacements;  // by organ, V x 3, m; 0 rows until asked for
  std::shared_ptr<SharedPictures> pictures;
};

/// Sessions of one model that step together.
class BatchData {
 public:
  BatchData(std::shared_ptr<const SessionModel> model, std::vector<DeviceChoice> devices,
            const std::vector<std::uint32_t>& seeds, CommandKind kind, int threads);
  ~BatchData();

  void Step();
  /// `seeds`: one for each of `which`.
  void Reset(const std::vector<int>& which, const std::vector<std::uint32_t>& seeds);
  void Load(int index, const SessionData& state);
  const SessionData& at(int index) const { return *sessions_[static_cast<std::size_t>(index)]; }
  SessionData& at(int index) { return *sessions_[static_cast<std::size_t>(index)]; }
  int count() const { return static_cast<int>(sessions_.size()); }
  int threads() const { return pool_->threads(); }
  std::size_t tools() const { return sessions_[0]->session.tools().size(); }
  std::size_t organs() const { return sessions_[0]->session.model().organs().size(); }

  // Session after session.
  std::vector<double> commands;      // count x instruments x 5
  std::vector<ToolView> views;       // count x instruments
  std::vector<double> organ_forces;  // count x organs x 3
  std::atomic<bool> busy = false;

 private:
  void Collect(int index);
  void TakeCommands(int index);

  std::vector<std::unique_ptr<SessionData>> sessions_;
  ProcessCheck process_;
  std::unique_ptr<WorkerPool> pool_;
};

}  // namespace hpdm
