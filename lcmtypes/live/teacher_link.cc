#include "lcmtypes/live/teacher_link.h"

#include <algorithm>
#include <lcm/lcm-cpp.hpp>

#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

constexpr char kTeacherOption[] = "--teacher";
constexpr std::size_t kMaxTextBytes = 60;

bool IsInPicture(double share) { return share >= 0 && share <= 1; }

}  // namespace

bool ReadRequest(std::span<const std::uint8_t> bytes, TeacherRequest* request) {
  teacher_t message;
  if (!DecodeMessage(bytes, &message) || message.text.size() > kMaxTextBytes) return false;
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  if (std::ranges::any_of(message.text, is_control)) return false;
  switch (message.request) {
    case teacher_t::PAUSE:
      request->kind = TeacherRequest::Kind::kPause;
      break;
    case teacher_t::CONTINUE:
      request->kind = TeacherRequest::Kind::kContinue;
      break;
    case teacher_t::POINT:
      request->kind = TeacherRequest::Kind::kPoint;
      break;
    case teacher_t::BLEED:
      request->kind = TeacherRequest::Kind::kBleed;
      break;
    case teacher_t::RESTART:
      request->kind = TeacherRequest::Kind::kRestart;
      if (message.step < 0) return false;
      request->step = message.step == 0 ? RestartRequest::kPresent : message.step - 1;
      break;
    default:
      return false;
  }
  const bool has_place = message.request == teacher_t::POINT || message.request == teacher_t::BLEED;
  if (has_place && !(IsInPicture(message.x) && IsInPicture(message.y))) return false;
  request->x = has_place ? message.x : 0;
  request->y = has_place ? message.y : 0;
  request->text.fill(0);
  std::ranges::copy(message.text, request->text.begin());
  return true;
}

TeacherLink::TeacherLink(const std::string& url, SpscQueue<TeacherRequest>* requests)
    : requests_(*requests), lcm_(ConnectToReceive(url, kTeacherOption)) {
  if (lcm_->subscribeFunction(kTeacherChannel, HandleReceived, this) == nullptr) {
    FailToConnect(url, kTeacherOption);
  }
  receiver_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) lcm_->handleTimeout(kReceivePatienceMs);
  });
}

TeacherLink::~TeacherLink() {
  receiver_.request_stop();
  receiver_.join();
}

void TeacherLink::HandleReceived(const lcm::ReceiveBuffer* received, const std::string&,
                                 TeacherLink* link) {
  TeacherRequest request;
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  if (ReadRequest({data, received->data_size}, &request)) link->requests_.Push(request);
}

}  // namespace hpdm
