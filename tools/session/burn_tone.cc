#include "tools/session/burn_tone.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

namespace hpdm {
namespace {

constexpr int kRate = 44100;          // Hz
constexpr int kSamples = kRate / 10;  // whole periods, so that it repeats without a click

}  // namespace

BurnTone::BurnTone(ALCdevice* device, const ALCint* attributes) : device_(device) {
  if (device_ == nullptr) {
    Fail("there is no sound output");
    return;
  }
  context_ = alcCreateContext(device_, attributes);
  if (context_ == nullptr || alcMakeContextCurrent(context_) == ALC_FALSE) {
    Fail("the sound output gives no context");
    return;
  }
  std::vector<std::int16_t> wave(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double value = kAmplitude * std::sin(2 * std::numbers::pi * kFrequency * i / kRate);
    wave[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::lround(32767 * value));
  }
  alGenBuffers(1, &buffer_);
  alBufferData(buffer_, AL_FORMAT_MONO16, wave.data(),
               static_cast<ALsizei>(wave.size() * sizeof(std::int16_t)), kRate);
  alGenSources(1, &source_);
  alSourcei(source_, AL_BUFFER, static_cast<ALint>(buffer_));
  alSourcei(source_, AL_LOOPING, AL_TRUE);
  if (alGetError() != AL_NO_ERROR) Fail("the sound output refuses it");
}

BurnTone::~BurnTone() {
  if (context_ != nullptr) {
    alDeleteSources(1, &source_);
    alDeleteBuffers(1, &buffer_);
    alcMakeContextCurrent(nullptr);
    alcDestroyContext(context_);
  }
  if (device_ != nullptr) alcCloseDevice(device_);
}

void BurnTone::Sound(bool on) {
  if (on == on_ || !failure_.empty()) return;
  on_ = on;
  if (on) {
    alSourcePlay(source_);
  } else {
    alSourceStop(source_);
  }
}

}  // namespace hpdm
