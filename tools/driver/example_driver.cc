// Example driver for `hpdm run SCENE --device lcm`: a simulated hand, on a spring and a damper,
// that moves in and out and yields to the session's force. A real driver reads its encoders instead
// of calling Step and writes its motors where `effort` is used. It needs only LCM and the message
// types; haptics/device/README.md states their contract.

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <thread>

#include "hpdm/device_t.hpp"
#include "hpdm/force_t.hpp"

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

struct Hand {
  double insertion = 0.14, velocity = 0;  // m, m/s
  double effort = 0;                      // N along the insertion axis, from the session
  Clock::time_point effort_time;          // when it was received

  void Step(double t, double dt) {
    constexpr double kMass = 0.3, kStiffness = 300, kDamping = 6;  // kg, N/m, N s/m
    const double target = 0.14 + 0.035 * std::sin(3 * t), speed = 0.105 * std::cos(3 * t);
    const double pull = kStiffness * (target - insertion) + kDamping * (speed - velocity);
    velocity += dt * (pull + effort) / kMass;
    insertion += dt * velocity;
  }
};

void TakeForce(const lcm::ReceiveBuffer*, const std::string&, const hpdm::force_t* f, Hand* hand) {
  if (f->tools.empty()) return;
  hand->effort = f->tools[0].effort[2];
  hand->effort_time = Clock::now();
}

int main() {
  const char* url = std::getenv("LCM_DEFAULT_URL");
  lcm::LCM lcm(url != nullptr ? url : "udpm://239.255.76.67:7667?ttl=0");
  if (!lcm.good()) return 3;
  Hand hand;
  lcm.subscribeFunction("HPDM_FORCE", TakeForce, &hand);
  const Clock::time_point start = Clock::now();
  for (int i = 1;; ++i) {
    std::this_thread::sleep_until(start + milliseconds(i));
    while (lcm.handleTimeout(0) > 0) {  // every force that has arrived
    }
    if (Clock::now() - hand.effort_time > milliseconds(50))
      hand.effort = 0;  // the session is silent: no force
    hand.Step(1e-3 * i, 1e-3);
    const std::chrono::nanoseconds now = Clock::now().time_since_epoch();
    const hpdm::device_t reading{i, now.count(), 0, {0, 0, hand.insertion, 0, 1}, true, false};
    lcm.publish("HPDM_DEVICE", &reading);
  }
}
