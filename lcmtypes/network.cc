#include "lcmtypes/network.h"

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>

#include "engine/error.h"

namespace hpdm {

std::string NetworkUrl() {
  const char* variable = std::getenv("LCM_DEFAULT_URL");
  return variable != nullptr && *variable != '\0' ? variable : kLocalUrl;
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
