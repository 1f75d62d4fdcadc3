#pragma once

#include <unistd.h>

#include <cstdlib>
#include <string>

/// Tests that use multicast run in a private network namespace, so that no packet reaches or leaves
/// a real network. The test starts its executable again inside one, with a filter that names it and
/// kInsideVariable set.
namespace hpdm {

inline constexpr char kInsideVariable[] = "HPDM_TEST_NAMESPACE";

inline bool InsideNetworkNamespace() { return std::getenv(kInsideVariable) != nullptr; }

/// Returns the command that enters a namespace here ("unshare -n", or with a user namespace); empty
/// if refused. `mounts`: file systems can be mounted in it too.
inline std::string NetworkNamespaceCommand(bool mounts = false) {
  for (const char* flags : {"-n", "-rn"}) {
    const std::string command = std::string("unshare ") + flags + (mounts ? "m" : "");
    const std::string trial =
        command +
        " sh -c 'ip link set lo up && ip link set lo multicast on && ip route add 239.255.76.67 "
        "dev lo" +
        (mounts ? " && mount -t tmpfs none /mnt" : "") + "' >/dev/null 2>&1";
    if (std::system(trial.c_str()) == 0) return command;
  }
  return {};
}

/// Runs the tests `filter` of this executable inside a namespace with LCM's multicast group on the
/// loopback; the exit status as std::system gives it.
inline int RunInNetworkNamespace(const std::string& enter, const std::string& filter) {
  const std::string command =
      enter +
      " sh -c 'ip link set lo up; ip link set lo multicast on; ip route add 239.255.76.67 dev lo; "
      "unset LCM_DEFAULT_URL; " +
      kInsideVariable + "=1 exec \"$0\" --gtest_filter=" + filter + "' /proc/" +
      std::to_string(getpid()) + "/exe";
  return std::system(command.c_str());
}

}  // namespace hpdm
