#include "scenes/loader/file_hash.h"

#include <glib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {

std::string Sha256OfFile(const std::filesystem::path& path) {
  const auto fail = [&path](const char* reason) {
    throw InputError(path.string() + ": cannot be read (" + reason +
                     "); check the file and its permissions");
  };
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(std::strerror(errno));
  const std::unique_ptr<GChecksum, decltype(&g_checksum_free)> sum(
      g_checksum_new(G_CHECKSUM_SHA256), g_checksum_free);
  std::vector<char> block(1 << 16);
  while (file) {
    file.read(block.data(), static_cast<std::streamsize>(block.size()));
    g_checksum_update(sum.get(), reinterpret_cast<const guchar*>(block.data()), file.gcount());
  }
  if (file.bad()) fail("read error");
  return g_checksum_get_string(sum.get());
}

bool IsSha256(const std::string& text) {
  return text.size() == 64 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

}  // namespace hpdm
