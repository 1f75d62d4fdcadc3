#include "tools/spy/spy_source.h"

#include "lcmtypes/live/network.h"

namespace hpdm {

SpySource::SpySource(const std::string& log) : name_(log.empty() ? NetworkUrl() : log) {
  if (log.empty()) {
    live_ = std::make_unique<LiveSource>(name_, "spy");
  } else {
    player_ = std::make_unique<LogPlayer>(name_);
  }
}

}  // namespace hpdm
