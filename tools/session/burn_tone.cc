#include "tools/session/burn_tone.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <system_error>
#include <vector>

namespace hpdm {
namespace {

constexpr int kRate = 44100;          // Hz
constexpr int kSamples = kRate / 10;  // whole periods, so that it repeats without a click

// False if there is neither a sound card nor a sound server: libraries would say so in ten lines.
bool MayHaveOutput() {
  if (std::getenv("ALSOFT_DRIVERS") != nullptr || std::getenv("PULSE_SERVER") != nullptr)
    return true;
  const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code none;
  return std::filesystem::exists("/dev/snd", none) ||
         (runtime != nullptr &&
          std::filesystem::exists(std::filesystem::path(runtime) / "pulse/native", none));
}

}  // namespace

BurnTone::BurnTone() : BurnTone(MayHaveOutput() ? alcOpenDevice(nullptr) : nullptr, nullptr) {}

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
