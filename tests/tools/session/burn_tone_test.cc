// The tone as a device of OpenAL renders it into memory.
#define AL_ALEXT_PROTOTYPES
#include "tools/session/burn_tone.h"

#include <AL/alext.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace hpdm {
namespace {

constexpr int kRate = 44100;  // Hz

std::vector<float> Rendered(ALCdevice* device, int samples) {
  std::vector<float> sound(static_cast<std::size_t>(samples));
  alcRenderSamplesSOFT(device, sound.data(), samples);
  return sound;
}

float Largest(const std::vector<float>& sound) {
  float largest = 0;
  for (const float value : sound) largest = std::max(largest, std::abs(value));
  return largest;
}

TEST(BurnTone, SoundsAtItsFrequencyWhileOn) {
  ALCdevice* const device = alcLoopbackOpenDeviceSOFT(nullptr);
  ASSERT_NE(device, nullptr);
  const ALCint attributes[] = {ALC_FORMAT_CHANNELS_SOFT,
                               ALC_MONO_SOFT,
                               ALC_FORMAT_TYPE_SOFT,
                               ALC_FLOAT_SOFT,
                               ALC_FREQUENCY,
                               kRate,
                               0};
  BurnTone tone(device, attributes);
  ASSERT_EQ(tone.failure(), "");
  EXPECT_EQ(Largest(Rendered(device, kRate / 10)), 0) << "not yet";
  tone.Sound(true);
  Rendered(device, kRate / 10);  // the output may fade in
  const std::vector<float> sound = Rendered(device, kRate);
  EXPECT_GT(Largest(sound), 0.3 * BurnTone::kAmplitude);
  EXPECT_LE(Largest(sound), 1.5 * BurnTone::kAmplitude);
  int rises = 0;
  for (std::size_t i = 1; i < sound.size(); ++i) rises += sound[i - 1] < 0 && sound[i] >= 0 ? 1 : 0;
  EXPECT_NEAR(rises, BurnTone::kFrequency, 2) << "in a second";
  tone.Sound(false);
  Rendered(device, kRate / 10);
  EXPECT_EQ(Largest(Rendered(device, kRate / 10)), 0) << "off again";
}

TEST(BurnTone, IsSilentWithoutAnOutput) {
  BurnTone tone(nullptr, nullptr);
  EXPECT_NE(tone.failure(), "");
  tone.Sound(true);
  tone.Sound(false);
}

}  // namespace
}  // namespace hpdm
