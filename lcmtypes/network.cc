#include "lcmtypes/network.h"

#include <charconv>
#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <string_view>
#include <system_error>

#include "engine/error.h"

namespace hpdm {

namespace {

/// Whether liblcm takes the multicast address: nothing, which is its own, or A.B.C.D:PORT. Of
/// another it says so on stderr, in words of its own.
bool IsMulticast(std::string_view address) {
  if (address.empty()) return true;
  int numbers[5] = {};  // the port last
  const char* at = address.data();
  const char* const end = at + address.size();
  for (int i = 0; i < 5; ++i) {
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const char after = i < 3 ? '.' : ':';
    if (error != std::errc() || (i < 4 ? next == end || *next != after : next != end)) return false;
    if (numbers[i] < 0 || numbers[i] > (i < 4 ? 255 : 65535)) return false;
    at = next + 1;
  }
  return numbers[0] >= 224 && numbers[0] <= 239;
}

bool IsUrl(std::string_view url) {
  constexpr std::string_view kMulticast = "udpm://";
  if (url.starts_with(kMulticast)) {
    return IsMulticast(url.substr(kMulticast.size(), url.find('?') - kMulticast.size()));
  }
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
  throw InputError("LCM_DEFAULT_URL=" + url + ": is no address of LCM; give such as " + kLocalUrl +
                   ", or unset it");
}

std::unique_ptr<lcm::LCM> Connect(const std::string& url, const std::string& option) {
  auto connection = std::make_unique<lcm::LCM>(url);
  if (!connection->good()) FailToConnect(url, option);
  return connection;
}

void FailToConnect(const std::string& url, const std::string& option) {
  throw MachineError(option + ": LCM cannot open " + url +
                     ": set LCM_DEFAULT_URL, or give the machine a multicast route "
                     "(ip route add 239.255.76.67 dev lo)");
}

}  // namespace hpdm
