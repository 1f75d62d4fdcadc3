#include "lcmtypes/live/live_source.h"

#include <algorithm>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <utility>

#include "lcmtypes/live/network.h"

namespace hpdm {
namespace {

// Messages are taken in batches, which saves a wake-up for each.
constexpr auto kPause = std::chrono::milliseconds(4);
// LCM's queue holds the messages of one pause at one per microsecond. It is limited by number only:
// with 64 kB each, a UDP packet, it takes 256 MB. LCM does not count the messages it drops.
constexpr int kLcmQueue = 1 << 12;
constexpr std::size_t kMaxBatch = 1024;
constexpr std::size_t kMaxSpent = 4096;
constexpr std::size_t kMaxSpentBytes = 4096;  // memory of longer messages is released

/// Requests as large a buffer as the system grants, up to 8 MB: a second of a session, and the
/// meshes.
std::string WithLargeBuffer(const std::string& url) {
  if (!url.starts_with("udpm://") || url.find("recv_buf_size") != std::string::npos) return url;
  long granted = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> granted;
  if (granted <= 0) return url;
  const char* separator = url.find('?') == std::string::npos ? "?" : "&";
  return url + separator + "recv_buf_size=" + std::to_string(std::min(granted, 8L << 20));
}

}  // namespace

LiveSource::LiveSource(const std::string& url, const std::string& option)
    : lcm_(ConnectToReceive(WithLargeBuffer(url), option)) {
  lcm::Subscription* subscription = lcm_->subscribeFunction(".*", Receive, this);
  if (subscription == nullptr) FailToConnect(url, option);
  subscription->setQueueCapacity(kLcmQueue);
  collector_ = std::jthread([this](std::stop_token stop) { Collect(stop); });
}

LiveSource::~LiveSource() = default;

void LiveSource::Receive(const lcm::ReceiveBuffer* received, const std::string& channel,
                         LiveSource* source) {
  if (source->batched_ == source->batch_.size()) source->batch_.emplace_back();
  LogEvent& event = source->batch_[source->batched_++];
  event.time_us = received->recv_utime;
  event.channel = channel;
  const auto* data = static_cast<const std::uint8_t*>(received->data);
  event.data.assign(data, data + received->data_size);
}

void LiveSource::Collect(std::stop_token stop) {
  std::int64_t number = 0;
  while (!stop.stop_requested()) {
    int handled = lcm_->handleTimeout(kReceivePatienceMs);
    while (handled > 0 && batched_ < kMaxBatch) handled = lcm_->handleTimeout(0);
    {
      const std::lock_guard lock(mutex_);
      for (std::size_t i = 0; i < batched_; ++i) {
        LogEvent& event = batch_[i];
        event.number = number++;
        const std::size_t bytes = event.data.size();
        if (waiting_.size() >= kMaxWaitingMessages || waiting_bytes_ + bytes > kMaxWaitingBytes) {
          ++dropped_;
          if (event.data.capacity() > kMaxSpentBytes) event.data = {};
          continue;
        }
        waiting_bytes_ += bytes;
        waiting_.push_back(std::move(event));
        if (!spent_.empty()) {
          event = std::move(spent_.back());
          spent_.pop_back();
        }
      }
    }
    if (batched_ > 0) arrived_.notify_one();
    const bool more = batched_ >= kMaxBatch;
    batched_ = 0;
    // A broken connection returns at once, every time.
    if (!more) std::this_thread::sleep_for(kPause);
  }
}

bool LiveSource::Next(LogEvent* event, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  if (waiting_.empty() && patience.count() > 0) {
    arrived_.wait_for(lock, patience, [this] { return !waiting_.empty(); });
  }
  if (waiting_.empty()) return false;
  std::swap(*event, waiting_.front());
  LogEvent& spent = waiting_.front();
  if (spent_.size() < kMaxSpent && spent.data.capacity() <= kMaxSpentBytes) {
    spent_.push_back(std::move(spent));
  }
  waiting_.pop_front();
  waiting_bytes_ -= event->data.size();
  return true;
}

std::uint64_t LiveSource::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace hpdm
