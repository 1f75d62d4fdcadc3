#include "tools/shared/schema_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "engine/base/error.h"

namespace hpdm {

MessageSchemas SchemasWith(const std::vector<std::string>& files) {
  std::vector<std::string> texts;
  for (const std::string& path : files) {
    std::ifstream file;
    std::error_code ignored;
    if (std::filesystem::is_regular_file(path, ignored)) file.open(path);
    texts.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    if (!file.is_open() || file.bad()) {
      throw InputError(path + ": cannot be read; give a file of LCM types");
    }
  }
  return MessageSchemas::HpdmAnd(texts, files);
}

}  // namespace hpdm
