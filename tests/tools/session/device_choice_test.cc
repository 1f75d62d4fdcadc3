#include "tools/session/device_choice.h"

#include <gtest/gtest.h>

#include "engine/base/error.h"

namespace hpdm {
namespace {

std::vector<InstrumentOptions> LeftAndRight() {
  std::vector<InstrumentOptions> instruments(2);
  instruments[0].name = "left";
  instruments[1].name = "right";
  return instruments;
}

std::vector<std::string> Chosen(const std::vector<std::string>& arguments,
                                const std::vector<InstrumentOptions>& instruments,
                                bool window = false) {
  std::vector<std::string> texts;
  for (const DeviceChoice& choice : ChooseDevices(arguments, instruments, window)) {
    texts.push_back(choice.Text());
  }
  return texts;
}

using Texts = std::vector<std::string>;

TEST(DeviceChoice, WithoutAnArgumentItIsTheScenesTraceOrTheSimulatedHand) {
  std::vector<InstrumentOptions> instruments = LeftAndRight();
  instruments[1].trace.file = "r.csv";
  EXPECT_EQ(Chosen({}, instruments), (Texts{"sim", "trace:r.csv"}));
  EXPECT_EQ(Chosen({"sim"}, instruments), (Texts{"sim", "sim"}));
}

TEST(DeviceChoice, AWindowsMouseStandsInForTheSimulatedHand) {
  std::vector<InstrumentOptions> instruments = LeftAndRight();
  EXPECT_EQ(Chosen({}, instruments, true), (Texts{"mouse", "mouse"}));
  EXPECT_EQ(Chosen({"right=sim"}, instruments, true), (Texts{"mouse", "sim"}));
  EXPECT_EQ(Chosen({"sim", "left=mouse"}, instruments, true), (Texts{"mouse", "sim"}));
  instruments[1].trace.file = "r.csv";
  EXPECT_EQ(Chosen({}, instruments, true), (Texts{"mouse", "trace:r.csv"}));
  EXPECT_THROW(ChooseDevices({"mouse"}, instruments), InputError);
  EXPECT_THROW(ChooseDevices({"left=mouse"}, instruments), InputError);
}

TEST(DeviceChoice, OneInstrumentsArgumentIsStrongerThanAllOfThemInAnyOrder) {
  EXPECT_EQ(Chosen({"right=lcm", "trace:a.csv"}, LeftAndRight()), (Texts{"trace:a.csv", "lcm"}));
  EXPECT_EQ(Chosen({"left=trace:l.csv", "right=trace:r.csv"}, LeftAndRight()),
            (Texts{"trace:l.csv", "trace:r.csv"}));
  EXPECT_EQ(Chosen({"trace:a=b.csv"}, LeftAndRight()), (Texts{"trace:a=b.csv", "trace:a=b.csv"}));
}

TEST(DeviceChoice, AnUnknownDeviceOrInstrumentIsAnInputErrorThatListsTheKnownOnes) {
  const auto error = [](const std::string& argument) -> std::string {
    try {
      ChooseDevices({argument}, LeftAndRight());
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  for (const char* argument : {"piano", "", "trace:", "left=", "left=piano", "left=trace:"}) {
    EXPECT_NE(error(argument).find("unknown device \""), std::string::npos) << argument;
  }
  EXPECT_NE(error("=lcm").find("unknown instrument; the scene has left, right"), std::string::npos);
  EXPECT_NE(error("middle=sim").find("unknown instrument; the scene has left, right"),
            std::string::npos);
}

}  // namespace
}  // namespace hpdm
