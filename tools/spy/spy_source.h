#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "lcmtypes/live/live_source.h"
#include "lcmtypes/log/log_player.h"

namespace hpdm {

/// The source of `hpdm spy`: the network, or a log that is played.
class SpySource {
 public:
  /// Empty `log`: the network of NetworkUrl(). Throws InputError if the log cannot be read and
  /// MachineError if the network cannot be used.
  explicit SpySource(const std::string& log);

  MessageSource& messages() { return player_ ? static_cast<MessageSource&>(*player_) : *live_; }
  LogPlayer* player() { return player_.get(); }      ///< Null for the network.
  const std::string& name() const { return name_; }  ///< The network's URL, or the log's path.

  /// Returns the number of messages from the network that were not read in time.
  std::uint64_t dropped() const { return live_ ? live_->dropped() : 0; }

 private:
  std::string name_;
  std::unique_ptr<LogPlayer> player_;
  std::unique_ptr<LiveSource> live_;
};

}  // namespace hpdm
