#include "lcmtypes/live/network.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_arp.h>
#include <linux/if_packet.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr std::string_view kMulticast = "udpm://";
constexpr int kDefaultPort = 7667;  // LCM's default

/// Returns the number behind the last `name` in the text; -1 if there is none.
int NumberBehind(std::string_view text, std::string_view name) {
  const std::size_t at = text.rfind(name);
  int number = -1;
  if (at != std::string_view::npos) {
    std::from_chars(text.data() + at + name.size(), text.data() + text.size(), number);
  }
  return number;
}

/// True if sent messages may leave this machine.
bool ReachesOthers(std::string_view url) {
  const std::size_t options = url.find('?');
  return options != std::string_view::npos && NumberBehind(url.substr(options), "ttl=") > 0;
}

/// Returns this program's sockets that receive datagrams at a port.
std::vector<int> DatagramSockets(int port) {
  std::vector<int> sockets;
  std::error_code error;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
       !error && entry != end; entry.increment(error)) {
    const int descriptor = NumberBehind(entry->path().native(), "/");
    int type = 0;
    socklen_t size = sizeof type;
    sockaddr_in bound{};
    socklen_t bound_size = sizeof bound;
    if (getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_DGRAM &&
        getsockname(descriptor, reinterpret_cast<sockaddr*>(&bound), &bound_size) == 0 &&
        bound.sin_family == AF_INET && ntohs(bound.sin_port) == port) {
      sockets.push_back(descriptor);
    }
  }
  return sockets;
}

/// Restricts a socket to packets from this machine: multicast copies of its own packets, and
/// packets over the loopback. Other machines can send neither, whatever source address they claim.
bool TakeOwnPacketsOnly(int socket) {
  constexpr auto kPacketType = static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_PKTTYPE);
  constexpr auto kInterfaceType = static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_HATYPE);
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kPacketType),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PACKET_LOOPBACK, 2, 0),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kInterfaceType),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ARPHRD_LOOPBACK, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, 0xffffffff),  // accept the whole packet
      BPF_STMT(BPF_RET | BPF_K, 0),
  };
  const sock_fprog filter = {static_cast<unsigned short>(std::size(program)), program};
  return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) == 0;
}

/// Removes the packets from before the filter: waits until LCM has read them and, without a
/// subscription, dropped them. Gives up after a while if this machine keeps sending.
void ForgetEarlierPackets(int socket) {
  constexpr int kMaxWaits = 50;
  int waiting = 1;
  for (int i = 0; i < kMaxWaits && waiting > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (ioctl(socket, FIONREAD, &waiting) != 0) return;
  }
}

/// Returns the group of a multicast address that liblcm accepts: empty, which means its default, or
/// A.B.C.D:PORT. For others liblcm prints a message of its own on stderr.
std::optional<sockaddr_in> GroupOf(std::string_view address) {
  int numbers[5] = {239, 255, 76, 67, kDefaultPort};  // the port is last
  const char* at = address.data();
  const char* const end = at + address.size();
  for (int i = 0; i < 5 && !address.empty(); ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const char after = i < 3 ? '.' : ':';
    if (error != std::errc() || (i < 4 ? next == end || *next != after : next != end)) return {};
    if (numbers[i] < 0 || numbers[i] > (i < 4 ? 255 : 65535)) return {};
    at = next + 1;
  }
  if (numbers[0] < 224 || numbers[0] > 239) return {};
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(static_cast<std::uint16_t>(numbers[4]));
  std::uint32_t host = 0;
  for (int i = 0; i < 4; ++i) host = 256 * host + static_cast<std::uint32_t>(numbers[i]);
  group.sin_addr.s_addr = htonl(host);
  return group;
}

/// Returns the multicast group of a URL, or nothing.
std::optional<sockaddr_in> GroupOfUrl(std::string_view url) {
  if (!url.starts_with(kMulticast)) return {};
  return GroupOf(url.substr(kMulticast.size(), url.find('?') - kMulticast.size()));
}

/// True if this machine has a route to the group. Without one liblcm prints a page on stderr.
bool HasRoute(const sockaddr_in& group) {
  const int trial = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (trial < 0) return true;  // liblcm reports it
  const bool has = connect(trial, reinterpret_cast<const sockaddr*>(&group), sizeof group) == 0;
  close(trial);
  return has;
}

bool IsUrl(std::string_view url) {
  if (url.starts_with(kMulticast)) return GroupOfUrl(url).has_value();
  for (const char* other : {"mpudpm://", "tcpq://", "file://", "memq://"}) {
    if (url.starts_with(other)) return true;
  }
  return false;
}

}  // namespace

std::string NetworkUrl() {
  const char* variable = std::getenv("LCM_DEFAULT_URL");
  if (variable == nullptr || *variable == '\0') return kLocalUrl;
  const std::string url = variable;
  if (IsUrl(url)) return url;
  throw InputError("LCM_DEFAULT_URL=" + url + ": not an LCM address; give one such as " +
                   kLocalUrl + ", or unset it");
}

std::unique_ptr<lcm::LCM> Connect(const std::string& url, const std::string& option) {
  const std::optional<sockaddr_in> group = GroupOfUrl(url);
  if (group && !HasRoute(*group)) FailToConnect(url, option);
  auto connection = std::make_unique<lcm::LCM>(url);
  if (!connection->good()) FailToConnect(url, option);
  // Without its server liblcm would wait on no socket and abort the program.
  if (url.starts_with("tcpq://") && connection->getFileno() < 0) FailToConnect(url, option);
  return connection;
}

std::unique_ptr<lcm::LCM> ConnectToReceive(const std::string& url, const std::string& option) {
  auto connection = Connect(url, option);
  if (!url.starts_with(kMulticast) || ReachesOthers(url)) return connection;
  const int named = NumberBehind(std::string_view(url).substr(0, url.find('?')), ":");
  const int port = named > 0 ? named : kDefaultPort;
  const std::vector<int> others = DatagramSockets(port);        // sockets of other connections
  if (connection->getFileno() < 0) FailToConnect(url, option);  // opens the socket
  std::vector<int> sockets = DatagramSockets(port);
  std::erase_if(sockets, [&others](int socket) {
    return std::find(others.begin(), others.end(), socket) != others.end();
  });
  bool kept = !sockets.empty();
  for (const int socket : sockets) kept = TakeOwnPacketsOnly(socket) && kept;
  if (!kept) {
    throw MachineError(option + ": " + url +
                       " cannot be limited to this machine: the system refuses a filter on a "
                       "socket; add ttl=1 to hear other machines too");
  }
  for (const int socket : sockets) ForgetEarlierPackets(socket);
  return connection;
}

void FailToConnect(const std::string& url, const std::string& option) {
  throw MachineError(option + ": LCM cannot open " + url +
                     "; set LCM_DEFAULT_URL, or give the machine a multicast route "
                     "(ip route add 239.255.76.67 dev lo)");
}

}  // namespace hpdm
