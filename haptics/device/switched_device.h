#pragma once

#include "haptics/device/device.h"

namespace hpdm {

/// A device that displays forces under the conditions of its ForceSwitch and no others.
class SwitchedDevice : public Device {
 public:
  void Home() noexcept override { force_.Home(); }
  void EnableForce(bool on) noexcept override { force_.Enable(on); }
  void EmergencyStop() noexcept override { force_.EmergencyStop(); }
  bool ForceOn() const noexcept override { return force_.On(); }

 protected:
  ForceSwitch force_;
};

}  // namespace hpdm
