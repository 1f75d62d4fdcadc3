#pragma once

#include <AL/al.h>
#include <AL/alc.h>

#include <string>

namespace hpdm {

/// The tone of an electrosurgical unit, which sounds while a hook's pedal is pressed, through OpenAL.
/// One thread; a call does not wait for the sound.
class BurnTone {
 public:
  static constexpr double kFrequency = 450;  ///< Hz.
  static constexpr double kAmplitude = 0.2;  ///< Of full scale.

  /// Opens the machine's sound output. Without one the tone is silent; failure() says why.
  BurnTone();
  /// Takes an open device over, or none. `attributes`: those of alcCreateContext.
  BurnTone(ALCdevice* device, const ALCint* attributes);
  ~BurnTone();
  BurnTone(const BurnTone&) = delete;
  BurnTone& operator=(const BurnTone&) = delete;

  void Sound(bool on);

  /// One line; empty: the tone can be heard.
  const std::string& failure() const { return failure_; }

 private:
  void Fail(const std::string& why) { failure_ = "no tone while a hook burns: " + why; }

  ALCdevice* device_;
  ALCcontext* context_ = nullptr;
  ALuint buffer_ = 0, source_ = 0;
  bool on_ = false;
  std::string failure_;
};

}  // namespace hpdm
