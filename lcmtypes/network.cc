#include "lcmtypes/network.h"

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>

#include "engine/error.h"

namespace hpdm {

std::string NetworkUrl() {
  const char* variable = std::getenv("LCM_DEFAULT_URL");
  if (variable == nullptr || *variable == '\0') return kLocalUrl;
  const std::string url = variable;
  // Of any other liblcm says on stderr, in words of its own, that it has no such provider.
  for (const char* provider : {"udpm://", "mpudpm://", "tcpq://", "file://", "memq://"}) {
    if (url.starts_with(provider)) return url;
  }
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
