#pragma once

#include <memory>
#include <string>

namespace lcm {
class LCM;
}

namespace hpdm {

/// LCM's default multicast group, kept on this machine.
inline constexpr char kLocalUrl[] = "udpm://239.255.76.67:7667?ttl=0";

/// Longest wait of a receiving thread before it checks for a stop.
inline constexpr int kReceivePatienceMs = 20;

/// Returns the LCM address of sessions: LCM_DEFAULT_URL, or kLocalUrl if it is not set.
std::string NetworkUrl();

/// Opens `url` for `option` ("--live"), to send. Throws MachineError if that fails.
std::unique_ptr<lcm::LCM> Connect(const std::string& url, const std::string& option);

/// Opens `url` to send and receive; messages come after the first subscription. With a time to live
/// of 0 (the default) LCM keeps sent messages on this machine but receives from any network. This
/// connection then also drops what other machines sent, by multicast or to this machine's own
/// address. Throws MachineError, also if the filter for that cannot be set.
std::unique_ptr<lcm::LCM> ConnectToReceive(const std::string& url, const std::string& option);

/// Throws MachineError: the network that `option` needs cannot be opened.
[[noreturn]] void FailToConnect(const std::string& url, const std::string& option);

}  // namespace hpdm
