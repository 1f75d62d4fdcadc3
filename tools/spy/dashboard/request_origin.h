#pragma once

#include <string>
#include <vector>

namespace hpdm {

/// Returns this machine's names in a network, in lower case: its host name, the same up to the
/// first dot, and the latter with ".local".
std::vector<std::string> NamesOfMachine();

/// True if a header "Host: name[:port]" means a server that listens on `bound` ("127.0.0.1", "::",
/// a name). A server on all addresses accepts any address and the machine's own names. Other names
/// are refused: another site's name may have been redirected to this machine.
bool MeansThisServer(const std::string& host_header, const std::string& bound);

/// True if two hosts with their ports, or two origins, are equal, ignoring case.
bool SameHost(const std::string& a, const std::string& b);

bool IsAllAddresses(const std::string& bound);

}  // namespace hpdm
