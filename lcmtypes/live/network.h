#pragma once

#include <memory>
#include <string>

namespace lcm {
class LCM;
}

namespace hpdm {

/// LCM's default multicast group, kept on this machine.
inline constexpr char kLocalUrl[] = "udpm://239.255.76.67:7667?ttl=0";

/// How long a receiving thread waits before it looks whether it is to stop.
inline constexpr int kReceivePatienceMs = 20;

/// Where a session speaks LCM: LCM_DEFAULT_URL, or else kLocalUrl.
std::string NetworkUrl();

/// Opens `url` for `option` ("--live"), to send. Throws MachineError where no network lets it.
std::unique_ptr<lcm::LCM> Connect(const std::string& url, const std::string& option);

/// Opens `url` to receive too; messages begin to come with the first subscription. A time to live
/// of 0 (also where `url` names none) keeps what is sent on this machine, but LCM receives from any
/// network all the same: here such a connection takes nothing that another machine sent, by
/// multicast or to this machine's own address. Throws MachineError, also where that cannot be had.
std::unique_ptr<lcm::LCM> ConnectToReceive(const std::string& url, const std::string& option);

/// The error of a network that lacks, for what `option` asked for.
[[noreturn]] void FailToConnect(const std::string& url, const std::string& option);

}  // namespace hpdm
