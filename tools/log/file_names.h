#pragma once

#include <cctype>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace hpdm {

/// Makes unique file names, without an extension, of names in a log: without the characters of a
/// path, at most 200 bytes, with a number if two were equal.
class FileNames {
 public:
  std::string Of(std::string_view name) {
    std::string plain;
    for (const char c : name.substr(0, kMaxNameBytes)) {
      const bool kept = std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-';
      plain += kept ? c : '_';
    }
    int& number = numbers_[plain];
    std::string numbered = ++number == 1 ? plain : Numbered(plain, number);
    while (!taken_.insert(numbered).second) numbered = Numbered(plain, ++number);
    return numbered;
  }

 private:
  // The longest file name (255 bytes), less "_1234567.csv.part-1234567890".
  static constexpr std::size_t kMaxNameBytes = 200;

  static std::string Numbered(const std::string& name, int number) {
    return name + "_" + std::to_string(number);
  }

  std::set<std::string> taken_;
  std::map<std::string, int> numbers_;  // last number of each name
};

}  // namespace hpdm
