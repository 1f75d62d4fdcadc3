#include "lcmtypes/live/network.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/error.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/live/live_source.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/network_namespace.h"

namespace hpdm {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr auto kPatience = milliseconds(20'000);  // a machine under load; usual are a few ms
constexpr char kOtherMachinesToo[] = "udpm://239.255.76.67:7667?ttl=1";

/// Sends to an address what LCM takes for a message "TEXT" on HPDM_DEVICE.
void SendDatagram(int socket, const char* address, const std::string& text) {
  std::string message = "LC02";
  message += std::string(4, '\0') + kDeviceChannel + '\0' + text;  // its number, channel, data
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(7667);
  inet_pton(AF_INET, address, &to.sin_addr);
  sendto(socket, message.data(), message.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to);
}

/// Another machine on this one's network: a process in a network namespace of its own, with a cable
/// to this one's. It keeps sending to the multicast group and to this machine's own address.
class OtherMachine {
 public:
  OtherMachine() {
    int ready[2], plugged[2];
    if (pipe(ready) != 0 || pipe(plugged) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      char byte = unshare(CLONE_NEWNET) == 0 ? '+' : '-';
      if (write(ready[1], &byte, 1) == 1 && read(plugged[0], &byte, 1) == 1) SendForEver();
      _exit(1);
    }
    char byte = '-';
    const std::string plug =
        "ip link add here type veth peer name there && "
        "ip addr add 10.9.0.1/24 dev here && ip link set here up && "
        "ip link set there netns " +
        std::to_string(process_) +
        // Multicast goes out to the cable, and comes in from it.
        " && ip route del 239.255.76.67 dev lo && ip route add 239.255.76.67 dev here";
    is_there_ = read(ready[0], &byte, 1) == 1 && byte == '+' && std::system(plug.c_str()) == 0 &&
                write(plugged[1], "+", 1) == 1;
    for (const int end : {ready[0], ready[1], plugged[0], plugged[1]}) close(end);
  }
  ~OtherMachine() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  OtherMachine(const OtherMachine&) = delete;
  OtherMachine& operator=(const OtherMachine&) = delete;

  bool is_there() const { return is_there_; }

 private:
  [[noreturn]] static void SendForEver() {
    const char* up =
        "ip addr add 10.9.0.2/24 dev there && ip link set there up && "
        "ip route add 239.255.76.67 dev there";
    if (std::system(up) != 0) _exit(1);
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    for (;; std::this_thread::sleep_for(milliseconds(5))) {
      SendDatagram(socket, "239.255.76.67", "multicast");
      SendDatagram(socket, "10.9.0.1", "unicast");
    }
  }

  pid_t process_ = -1;
  bool is_there_ = false;
};

/// How many messages of such a text come, until there are as many as wanted.
int Count(LiveSource* source, const std::string& text, int wanted) {
  const auto end = steady_clock::now() + kPatience;
  LogEvent event;
  int count = 0;
  while (count < wanted && steady_clock::now() < end) {
    if (!source->Next(&event, milliseconds(20))) continue;
    if (std::equal(event.data.begin(), event.data.end(), text.begin(), text.end())) ++count;
  }
  return count;
}

TEST(Network, ALocalReaderHearsNoOtherMachine) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "Network.ALocalReaderHearsNoOtherMachine"), 0);
    return;
  }
  const OtherMachine other;
  ASSERT_TRUE(other.is_there());
  LiveSource open(kOtherMachinesToo, "spy");
  ASSERT_EQ(Count(&open, "multicast", 1), 1) << "the other machine is heard by who asks for it";
  ASSERT_EQ(Count(&open, "unicast", 1), 1);

  LiveSource source(kLocalUrl, "spy");
  const SessionClock clock;
  SpscQueue<HapticSample> forces(64);
  SpscQueue<LoopEvent> events(64);
  DeviceLink link(kLocalUrl, clock, {{}, forces, &events});
  // 20 more from outside, of which those two would have heard the most.
  EXPECT_EQ(Count(&open, "multicast", 20), 20);
  lcm::LCM sender(kLocalUrl);
  const std::string own = "own";
  ASSERT_EQ(sender.publish(kDeviceChannel, own.data(), 3), 0);
  EXPECT_EQ(Count(&open, own, 1), 1);
  std::set<std::string> heard;
  LogEvent event;
  while (!heard.contains(own) && source.Next(&event, kPatience)) {
    heard.emplace(event.data.begin(), event.data.end());
  }
  EXPECT_TRUE(heard.contains(own));
  EXPECT_FALSE(heard.contains("multicast") || heard.contains("unicast"));

  // None of the messages is a valid reading: each is refused and counted, the first one reported.
  std::jthread receive([&link](std::stop_token stop) { link.Receive(stop); });
  LoopEvent reported;
  const auto end = steady_clock::now() + kPatience;
  while (!events.Pop(&reported) && steady_clock::now() < end) {
    std::this_thread::sleep_for(milliseconds(5));
  }
  receive.request_stop();
  receive.join();
  EXPECT_EQ(link.Summary().refused, 1u) << "this machine's own alone";
}

TEST(Network, WithoutARouteOnlyOurOwnErrorSpeaks) {
  if (!InsideNetworkNamespace()) {
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "Network.WithoutARouteOnlyOurOwnErrorSpeaks"), 0);
    return;
  }
  EXPECT_NE(Connect(kLocalUrl, "--live"), nullptr);
  ASSERT_EQ(std::system("ip route del 239.255.76.67 dev lo"), 0);
  testing::internal::CaptureStderr();
  EXPECT_THROW(Connect(kLocalUrl, "--live"), MachineError);
  EXPECT_THROW(ConnectToReceive("udpm://", "--device lcm"), MachineError);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "liblcm's own lines";
}

TEST(Network, AServerThatDoesNotRunIsReported) {
  EXPECT_THROW(Connect("tcpq://127.0.0.1:1", "--live"), MachineError);
}

}  // namespace
}  // namespace hpdm
