#include "tools/spy/dashboard/request_origin.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <algorithm>
#include <climits>

namespace hpdm {
namespace {

std::string Lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

// "localhost:8090" -> "localhost", "[::1]:8090" -> "::1".
std::string HostOf(const std::string& header) {
  if (header.starts_with('[')) return header.substr(1, header.find(']') - 1);
  return header.substr(0, header.rfind(':'));
}

bool IsAddress(const std::string& host) {
  in6_addr address;
  return inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

}  // namespace

std::vector<std::string> NamesOfMachine() {
  char text[HOST_NAME_MAX + 1] = {};
  if (gethostname(text, HOST_NAME_MAX) != 0 || text[0] == '\0') return {};
  const std::string whole = Lower(text);
  const std::string first(whole.begin(), std::find(whole.begin(), whole.end(), '.'));
  return {whole, first, first + ".local"};
}

bool IsAllAddresses(const std::string& bound) { return bound == "0.0.0.0" || bound == "::"; }

bool SameHost(const std::string& a, const std::string& b) { return Lower(a) == Lower(b); }

bool MeansThisServer(const std::string& host_header, const std::string& bound) {
  const std::string host = Lower(HostOf(host_header));
  if (host == "localhost" || host == "127.0.0.1" || host == "::1" || host == Lower(bound)) {
    return true;
  }
  if (!IsAllAddresses(bound)) return false;
  const std::vector<std::string> names = NamesOfMachine();
  return IsAddress(host) || std::find(names.begin(), names.end(), host) != names.end();
}

}  // namespace hpdm
