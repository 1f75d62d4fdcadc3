#pragma once

#include <string>
#include <vector>

namespace hpdm {

/// Names by which others may reach this machine: its host name, whole and up to the first dot, and
/// the latter's in ".local"; lower case.
std::vector<std::string> NamesOfMachine();

/// Whether a server that listens on `bound` ("127.0.0.1", "::", a name) is the one that a header
/// "Host: name[:port]" means. On all addresses any address may be meant and the machine's own
/// names, but no other: it may be another site's that was made to lead here.
bool MeansThisServer(const std::string& host_header, const std::string& bound);

/// Whether two hosts with their ports, or origins, are the same: without regard to case.
bool SameHost(const std::string& a, const std::string& b);

bool IsAllAddresses(const std::string& bound);

}  // namespace hpdm
