#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/live/teacher_link.h"
#include "lcmtypes/wire/codec.h"
#include "tools/command_line.h"
#include "tools/commands.h"

namespace hpdm {
namespace {

struct TeachOptions {
  std::string request;
  double x = 0.5, y = 0.5;
  int step = 0;
  std::string text;
};

teacher_t RequestOf(const TeachOptions& options) {
  teacher_t message{};
  message.sequence = 1;
  message.x = options.x;
  message.y = options.y;
  message.text = options.text;
  message.step = options.step;
  if (options.request == "pause") message.request = teacher_t::PAUSE;
  if (options.request == "continue") message.request = teacher_t::CONTINUE;
  if (options.request == "point") message.request = teacher_t::POINT;
  if (options.request == "bleed") message.request = teacher_t::BLEED;
  if (options.request == "restart") message.request = teacher_t::RESTART;
  return message;
}

void Teach(const TeachOptions& options) {
  std::vector<std::uint8_t> buffer;
  const std::span<const std::uint8_t> bytes = EncodeMessage(RequestOf(options), &buffer);
  TeacherRequest read;
  if (!ReadRequest(bytes, &read)) {
    throw InputError("--text " + OneLine(options.text) +
                     ": is longer than 60 bytes or has control characters; give a shorter text");
  }
  const std::string url = NetworkUrl();
  const std::unique_ptr<lcm::LCM> network = Connect(url, "teach");
  if (network->publish(kTeacherChannel, bytes.data(), static_cast<unsigned>(bytes.size())) != 0) {
    throw MachineError("teach: the network " + url +
                       " refused the message; check the interface and its multicast route");
  }
}

}  // namespace

void AddTeachCommand(Command app) {
  const auto options = std::make_shared<TeachOptions>();
  Command teach = app.AddCommand(
      "teach",
      "Send a request to the sessions on this network that listen to a teacher (hpdm run "
      "--teacher)");
  teach
      .AddOption("request", options->request,
                 "pause, continue, point (a mark in the picture for 10 s), bleed (a bleeding until "
                 "a clip), or restart (the exercise, at a step)")
      .OneOf({"pause", "continue", "point", "bleed", "restart"})
      .Required();
  teach.AddOption("--x", options->x, "Place of the mark, of the picture's width from its left")
      .From(0.0, 1.0)
      .ShowDefault();
  teach.AddOption("--y", options->y, "The same, of its height from its top")
      .From(0.0, 1.0)
      .ShowDefault();
  teach.AddOption("--step", options->step, "Step that begins again, from 1 [the present one]")
      .From(1.0, 1e6);
  teach.AddOption("--text", options->text, "Text beside the mark, up to 60 bytes");
  teach.OnRun([options] { Teach(*options); });
}

}  // namespace hpdm
