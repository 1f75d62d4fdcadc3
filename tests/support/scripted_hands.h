#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "engine/threads/session_clock.h"
#include "tools/session/lockstep_session.h"

namespace hpdm {

/// Two scripted hands on a gallbladder, the second organ of a scene with an exercise: a left grasper and
/// a right instrument. Every method that moves them runs the session's steps. Lengths are in m.
class ScriptedHands {
 public:
  enum Hand { kLeft, kRight };

  /// `near_W`: a place near the fundus; `bed`: the attachment that the gallbladder is lifted off.
  ScriptedHands(LockstepSession* session, const Vector3d& near_W, std::size_t bed)
      : session_(*session) {
    const SessionModel& model = session_.model();
    const Points& rest = model.organs()[1].rest().vertices;
    const Vector3d middle = rest.colwise().mean();
    (rest.rowwise() - near_W.transpose()).rowwise().squaredNorm().minCoeff(&fundus_);
    outward_W_ = (rest.row(fundus_).transpose() - middle).normalized();
    const Vector3d bed_W = model.beds()[bed].points_W[0].colwise().mean();
    away_W_ = (middle - bed_W).normalized();
    for (std::size_t t = 0; t < 2; ++t) {
      const auto& tip = session_.tools()[t].tip;
      tips_W_[t] = Vector3d(tip[0], tip[1], tip[2]);
    }
  }

  const ExerciseResult& result() const { return session_.exercise()->result(); }
  std::size_t done() const { return result().step_times.size(); }
  std::vector<std::string> Errors() const {
    std::vector<std::string> names;
    for (const ExerciseError& error : result().errors) {
      const auto rule = static_cast<std::size_t>(error.rule);
      names.push_back(session_.exercise()->options().errors[rule].name);
    }
    return names;
  }
  void Step(int count = 1) {
    for (int i = 0; i < count; ++i) {
      for (std::size_t t = 0; t < 2; ++t) {
        session_.Command(t, Kinematics(t).Inverse(tips_W_[t], rolls_[t], jaws_[t]).joints);
      }
      const Nanoseconds began = ThreadCpuTime();
      session_.Step();
      step_times_.push_back(ThreadCpuTime() - began);
    }
  }
  /// Processor time of each step so far, with its ticks and their log.
  const std::vector<Nanoseconds>& step_times() const { return step_times_; }
  /// Moves a tip straight to a place at a speed (m/s).
  void Move(std::size_t hand, const Vector3d& to_W, double speed) {
    const Vector3d from_W = tips_W_[hand];
    const int steps = std::max(1, static_cast<int>(30 * (to_W - from_W).norm() / speed));
    for (int i = 1; i <= steps; ++i) {
      tips_W_[hand] = from_W + i * (to_W - from_W) / steps;
      Step();
    }
  }
  void Jaws(std::size_t hand, double jaw) {
    const double from = jaws_[hand];
    for (int i = 1; i <= 10; ++i) {
      jaws_[hand] = from + i * (jaw - from) / 10;
      Step();
    }
  }
  /// Moves the left hand away from the bed by a length.
  void Lift(double length) { Move(kLeft, tips_W_[kLeft] + length * away_W_, 0.03); }

 protected:
  /// The left hand comes to tissue of the fundus at a speed (m/s) and closes its jaws on it.
  void Take(const Vector3d& place_W, double speed) {
    Move(kLeft, place_W + 0.03 * outward_W_, speed);
    Move(kLeft, place_W + 0.0015 * outward_W_, 0.03);
    Jaws(kLeft, 0);
    Step(20);
  }
  const ImpulseEngineKinematics& Kinematics(std::size_t hand) const {
    return session_.model().kinematics(hand);
  }

  LockstepSession& session_;
  Eigen::Index fundus_ = 0;  // vertex of the gallbladder
  Vector3d outward_W_, away_W_;
  std::array<Vector3d, 2> tips_W_;
  std::array<double, 2> rolls_{}, jaws_{1, 1};

 private:
  std::vector<Nanoseconds> step_times_;
};

}  // namespace hpdm
