#include "tools/shared/base64.h"

#include <glib.h>

#include <memory>

namespace hpdm {

std::string Base64(std::span<const std::byte> bytes) {
  const std::unique_ptr<gchar, decltype(&g_free)> text(
      g_base64_encode(reinterpret_cast<const guchar*>(bytes.data()), bytes.size()), g_free);
  return text.get();
}

}  // namespace hpdm
