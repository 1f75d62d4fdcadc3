#include "lcmtypes/wire/message_schema_parser.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "lcmtypes/wire/comment_units.h"

namespace hpdm {
namespace {

constexpr std::size_t kMaxDimensions = 16;

struct Primitive {
  std::string_view name;
  LcmPrimitive type;
};
constexpr Primitive kPrimitives[] = {
    {"int8_t", LcmPrimitive::kInt8},    {"int16_t", LcmPrimitive::kInt16},
    {"int32_t", LcmPrimitive::kInt32},  {"int64_t", LcmPrimitive::kInt64},
    {"byte", LcmPrimitive::kByte},      {"float", LcmPrimitive::kFloat},
    {"double", LcmPrimitive::kDouble},  {"string", LcmPrimitive::kString},
    {"boolean", LcmPrimitive::kBoolean}};

/// LCM's grammar: package, struct, const, members with dimensions.
class Parser {
 public:
  Parser(std::string_view text, const std::string& place) : text_(text), place_(place) {
    Advance();
  }

  std::vector<LcmStruct> Structs() {
    std::vector<LcmStruct> structs;
    while (!token_.empty()) {
      if (Accept("package")) {
        package_ = Name() + ".";
        Expect(";");
      } else if (Accept("struct")) {
        structs.push_back(Struct());
      } else {
        Refuse("expected struct or package");
      }
    }
    return structs;
  }

 private:
  LcmStruct Struct() {
    LcmStruct result;
    result.name = package_ + Name();
    Expect("{");
    while (!Accept("}")) {
      if (Accept("const")) {
        while (!Accept(";")) Take();
      } else {
        Members(&result);
      }
    }
    return result;
  }

  void Members(LcmStruct* in) {
    const std::string type_name = Name();
    const std::size_t first = in->members.size();
    do {
      LcmMember member{.name = Name(), .type_name = type_name};
      const auto* found = std::find_if(std::begin(kPrimitives), std::end(kPrimitives),
                                       [&](const Primitive& p) { return p.name == type_name; });
      if (found != std::end(kPrimitives)) {
        member.type = found->type;
      } else if (type_name.find('.') == std::string::npos) {
        member.type_name = package_ + type_name;
      }
      while (Accept("[")) {
        member.dimensions.push_back(Dimension(*in));
        Expect("]");
        if (member.dimensions.size() > kMaxDimensions) {
          Refuse("an array of more than " + std::to_string(kMaxDimensions) + " dimensions");
        }
      }
      in->members.push_back(std::move(member));
    } while (Accept(","));
    Expect(";");
    for (std::size_t m = first; m < in->members.size(); ++m) {
      LcmMember& member = in->members[m];
      const std::int64_t count = member.dimensions.size() == 1 ? member.dimensions[0].constant : -1;
      member.units = CommentUnits(comment_, member.name, count);
    }
  }

  LcmDimension Dimension(const LcmStruct& in) {
    LcmDimension dimension{.size = std::string(Take())};
    const char* end = dimension.size.data() + dimension.size.size();
    const auto parsed = std::from_chars(dimension.size.data(), end, dimension.constant);
    if (parsed.ec == std::errc() && parsed.ptr == end && dimension.constant >= 0) return dimension;
    dimension.constant = -1;
    for (std::size_t m = 0; m < in.members.size(); ++m) {
      if (in.members[m].name != dimension.size) continue;
      if (in.members[m].type > LcmPrimitive::kByte || !in.members[m].dimensions.empty()) break;
      dimension.member = m;
      return dimension;
    }
    Refuse("the size " + QuotedToken(dimension.size) +
           " is neither a number nor an integer member before it");
  }

  std::string Name() {
    const std::string name(Take());
    const bool fits = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.';
    });
    if (!fits) Refuse("expected a name, found " + QuotedToken(name));
    return name;
  }

  std::string_view Take() {
    if (token_.empty()) Refuse("the text ends too early");
    const std::string_view taken = token_;
    Advance();
    return taken;
  }
  bool Accept(std::string_view wanted) {
    if (token_ != wanted) return false;
    Advance();
    return true;
  }
  void Expect(std::string_view wanted) {
    if (token_.empty()) Refuse("the text ends too early");
    if (!Accept(wanted)) {
      Refuse("expected '" + std::string(wanted) + "', found " + QuotedToken(token_));
    }
  }

  void Advance() {
    const int line = line_;
    comment_ = {};
    for (;;) {
      while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) Step();
      if (text_.substr(at_, 2) == "//") {
        const std::size_t begin = at_ + 2;
        while (at_ < text_.size() && text_[at_] != '\n') Step();
        if (line_ == line) comment_ = text_.substr(begin, at_ - begin);
      } else if (text_.substr(at_, 2) == "/*") {
        while (at_ < text_.size() && text_.substr(at_, 2) != "*/") Step();
        at_ = std::min(at_ + 2, text_.size());
      } else {
        break;
      }
    }
    const std::size_t begin = at_;
    const auto in_word = [this](std::size_t i) {
      const char c = text_[i];
      return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-';
    };
    while (at_ < text_.size() && in_word(at_)) ++at_;
    if (at_ == begin && at_ < text_.size()) ++at_;
    token_ = text_.substr(begin, at_ - begin);
  }
  void Step() {
    if (text_[at_] == '\n') ++line_;
    ++at_;
  }

  [[noreturn]] void Refuse(const std::string& what) const {
    throw InputError(place_ + ":" + std::to_string(line_) + ": " + what +
                     "; give a file that lcm-gen accepts");
  }

  std::string_view text_;
  const std::string& place_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::string_view token_;
  std::string_view comment_;  // between the previous token and token_, on the previous one's line
  std::string package_;
};

}  // namespace

std::vector<LcmStruct> ParseLcmTypes(std::string_view text, const std::string& place) {
  return Parser(text, place).Structs();
}

}  // namespace hpdm
