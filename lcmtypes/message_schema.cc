#include "lcmtypes/message_schema.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "engine/error.h"
#include "engine/quoted_token.h"
#include "lcmtypes/lcm_texts.h"

namespace hpdm {
namespace {

constexpr std::size_t kHashBytes = 8;
constexpr std::size_t kMaxDimensions = 16;
// LCM permits recursive types; a message of one could nest as deep as it is long.
constexpr std::size_t kMaxDepth = 64;

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
    for (;;) {
      while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) Step();
      if (text_.substr(at_, 2) == "//") {
        while (at_ < text_.size() && text_[at_] != '\n') Step();
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
  std::string package_;
};

// LCM's hashes (lcm-gen 1.3.1). In unsigned arithmetic, with the sign carried by hand.
std::uint64_t Mixed(std::uint64_t v, std::uint64_t with) {
  const auto high = static_cast<std::uint64_t>(static_cast<std::int64_t>(v) >> 55);
  return ((v << 8) ^ high) + with;
}
std::uint64_t Mixed(std::uint64_t v, std::string_view text) {
  v = Mixed(v, text.size());
  // lcm-gen takes plain chars, which are signed; names hold none beyond ASCII.
  for (const char c : text) v = Mixed(v, static_cast<std::uint64_t>(c));
  return v;
}
std::uint64_t OwnHash(const LcmStruct& type) {
  std::uint64_t v = 0x12345678;
  for (const LcmMember& member : type.members) {
    v = Mixed(v, member.name);
    if (member.type != LcmPrimitive::kStruct) v = Mixed(v, member.type_name);
    v = Mixed(v, member.dimensions.size());
    for (const LcmDimension& dimension : member.dimensions) {
      v = Mixed(v, dimension.constant < 0 ? std::uint64_t{1} : std::uint64_t{0});
      v = Mixed(v, dimension.size);
    }
  }
  return v;
}

/// Hashes of types with the structs inside, except for those that hold the one in question. Each
/// member costs its struct's hash anew, so types of types of types can take longer than anybody
/// waits: those are refused.
class WholeHash {
 public:
  explicit WholeHash(const std::vector<LcmStruct>& structs) : structs_(structs) {}

  std::uint64_t Of(std::size_t index) {
    if (std::find(within_.begin(), within_.end(), index) != within_.end()) return 0;
    if (within_.size() > kMaxDepth || ++visits_ > kMaxVisits + structs_.size()) {
      const std::size_t whole = within_.empty() ? index : within_.front();
      throw InputError("LCM type " + QuotedToken(structs_[whole].name) +
                       ": holds too many structs inside of structs; give types that hold fewer");
    }
    within_.push_back(index);
    std::uint64_t v = OwnHash(structs_[index]);
    for (const LcmMember& member : structs_[index].members) {
      if (member.type == LcmPrimitive::kStruct) v += Of(member.struct_index);
    }
    within_.pop_back();
    return std::rotl(v, 1);
  }

 private:
  static constexpr std::size_t kMaxVisits = 100'000;  // of all types together, but for themselves
  const std::vector<LcmStruct>& structs_;
  std::vector<std::size_t> within_;
  std::size_t visits_ = 0;
};

/// Bytes of one value; 0 for those whose size they tell themselves.
std::int64_t FixedBytes(LcmPrimitive type) {
  switch (type) {
    case LcmPrimitive::kInt8:
    case LcmPrimitive::kByte:
    case LcmPrimitive::kBoolean:
      return 1;
    case LcmPrimitive::kInt16:
      return 2;
    case LcmPrimitive::kInt32:
    case LcmPrimitive::kFloat:
      return 4;
    case LcmPrimitive::kInt64:
    case LcmPrimitive::kDouble:
      return 8;
    case LcmPrimitive::kString:
    case LcmPrimitive::kStruct:
      return 0;
  }
  return 0;
}

/// Walks the bytes of one message. Without a `visitor` names are not made and arrays of numbers are
/// stepped over.
class Walk {
 public:
  Walk(const std::vector<LcmStruct>& structs, std::span<const std::uint8_t> bytes,
       MessageVisitor* visitor)
      : structs_(structs), bytes_(bytes), visitor_(visitor) {}

  bool Message(const LcmStruct& type, MessageOrder* order) {
    at_ = kHashBytes;
    order_ = order;
    steps_left_ = kStepsPerByte * bytes_.size();
    return bytes_.size() >= kHashBytes && Struct(type, 0) && at_ == bytes_.size();
  }

 private:
  bool Struct(const LcmStruct& type, std::size_t depth) {
    if (depth > kMaxDepth || !Spend()) return false;
    // Of the integer members so far, for the dimensions that they give.
    std::vector<std::int64_t> integers(type.members.size(), 0);
    const std::size_t prefix = name_.size();
    if (visitor_ != nullptr) visitor_->BeginStruct();
    for (std::size_t m = 0; m < type.members.size(); ++m) {
      const LcmMember& member = type.members[m];
      if (visitor_ != nullptr) {
        if (prefix > 0) name_ += '.';
        name_ += member.name;
        visitor_->BeginMember(member);
      }
      if (!Array(member, integers, 0, depth, &integers[m])) return false;
      name_.resize(prefix);
      if (depth == 0 && order_ != nullptr) Note(member, integers[m]);
    }
    if (visitor_ != nullptr) visitor_->EndStruct();
    return true;
  }

  // Structs and elements take bytes, but for empty ones: nested, these would never end.
  static constexpr std::size_t kStepsPerByte = 16;
  bool Spend() {
    if (steps_left_ == 0) return false;
    --steps_left_;
    return true;
  }

  void Note(const LcmMember& member, std::int64_t value) const {
    const bool integer = member.type <= LcmPrimitive::kByte && member.dimensions.empty();
    if (integer && member.name == "sequence") order_->sequence = value;
    if (integer && member.name == "instrument") order_->instrument = value;
  }

  bool Array(const LcmMember& member, const std::vector<std::int64_t>& integers,
             std::size_t dimension, std::size_t depth, std::int64_t* integer) {
    if (dimension == member.dimensions.size()) return Element(member, depth, integer);
    const LcmDimension& size = member.dimensions[dimension];
    const std::int64_t count = size.constant >= 0 ? size.constant : integers[size.member];
    // An element takes at least a byte, unless it is an empty struct, of which nobody needs many.
    if (count < 0 || count > static_cast<std::int64_t>(bytes_.size())) return false;
    const std::int64_t fixed = FixedBytes(member.type);
    if (visitor_ == nullptr && fixed > 0 && dimension + 1 == member.dimensions.size()) {
      if (count * fixed > static_cast<std::int64_t>(bytes_.size() - at_)) return false;
      at_ += static_cast<std::size_t>(count * fixed);
      return true;
    }
    const std::size_t prefix = name_.size();
    if (visitor_ != nullptr) visitor_->BeginArray();
    for (std::int64_t i = 0; i < count; ++i) {
      if (visitor_ != nullptr) {
        name_ += '[';
        name_ += std::to_string(i);
        name_ += ']';
      }
      std::int64_t unused = 0;
      if (!Spend()) return false;
      if (!Array(member, integers, dimension + 1, depth, &unused)) return false;
      name_.resize(prefix);
    }
    if (visitor_ != nullptr) visitor_->EndArray();
    return true;
  }

  bool Element(const LcmMember& member, std::size_t depth, std::int64_t* integer) {
    switch (member.type) {
      case LcmPrimitive::kStruct:
        return Struct(structs_[member.struct_index], depth + 1);
      case LcmPrimitive::kString:
        return String();
      case LcmPrimitive::kFloat: {
        std::uint64_t bits = 0;
        if (!Big(4, &bits)) return false;
        Tell(static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
        return true;
      }
      case LcmPrimitive::kDouble: {
        std::uint64_t bits = 0;
        if (!Big(8, &bits)) return false;
        Tell(std::bit_cast<double>(bits));
        return true;
      }
      case LcmPrimitive::kInt8:
      case LcmPrimitive::kBoolean:
        return Integer(1, true, integer);
      case LcmPrimitive::kByte:
        return Integer(1, false, integer);
      case LcmPrimitive::kInt16:
        return Integer(2, true, integer);
      case LcmPrimitive::kInt32:
        return Integer(4, true, integer);
      case LcmPrimitive::kInt64:
        return Integer(8, true, integer);
    }
    return false;
  }

  bool Integer(int size, bool is_signed, std::int64_t* integer) {
    std::uint64_t bits = 0;
    if (!Big(size, &bits)) return false;
    const int unused = 64 - 8 * size;
    *integer = is_signed ? static_cast<std::int64_t>(bits << unused) >> unused
                         : static_cast<std::int64_t>(bits);
    Tell(*integer);
    return true;
  }

  bool String() {
    std::uint64_t length = 0;  // with the final zero
    if (!Big(4, &length) || length == 0 || length > bytes_.size() - at_) return false;
    if (bytes_[at_ + length - 1] != 0) return false;
    Tell(std::string_view(reinterpret_cast<const char*>(bytes_.data() + at_), length - 1));
    at_ += length;
    return true;
  }

  template <typename Value>
  void Tell(Value value) const {
    if (visitor_ != nullptr) visitor_->Value({name_, value});
  }

  bool Big(int size, std::uint64_t* value) {
    if (bytes_.size() - at_ < static_cast<std::size_t>(size)) return false;
    *value = 0;
    for (int i = 0; i < size; ++i) *value = *value << 8 | bytes_[at_++];
    return true;
  }

  const std::vector<LcmStruct>& structs_;
  std::span<const std::uint8_t> bytes_;
  MessageVisitor* visitor_;
  MessageOrder* order_ = nullptr;
  std::size_t at_ = 0;
  std::size_t steps_left_ = 0;
  std::string name_;
};

class Values : public MessageVisitor {
 public:
  explicit Values(const std::function<void(const MessageValue&)>& visit) : visit_(visit) {}
  void Value(const MessageValue& value) override { visit_(value); }

 private:
  const std::function<void(const MessageValue&)>& visit_;
};

}  // namespace

MessageSchemas::MessageSchemas(std::span<const std::string_view> texts,
                               std::span<const std::string> names) {
  for (std::size_t t = 0; t < texts.size(); ++t) {
    for (LcmStruct& type : Parser(texts[t], names[t]).Structs())
      structs_.push_back(std::move(type));
  }
  Link();
}

void MessageSchemas::Link() {
  std::map<std::string_view, std::size_t> by_name;
  for (std::size_t s = 0; s < structs_.size(); ++s) {
    if (!by_name.emplace(structs_[s].name, s).second) {
      throw InputError("LCM type " + QuotedToken(structs_[s].name) +
                       ": is defined twice; give one file of them");
    }
  }
  for (LcmStruct& type : structs_) {
    for (LcmMember& member : type.members) {
      if (member.type != LcmPrimitive::kStruct) continue;
      const auto found = by_name.find(member.type_name);
      if (found == by_name.end()) {
        throw InputError("LCM type " + QuotedToken(type.name) + ": its member " +
                         QuotedToken(member.name) + " is of type " + QuotedToken(member.type_name) +
                         ", which is missing; give its .lcm file too");
      }
      member.struct_index = found->second;
    }
  }
  WholeHash whole_hash(structs_);
  for (std::size_t s = 0; s < structs_.size(); ++s) {
    structs_[s].hash = static_cast<std::int64_t>(whole_hash.Of(s));
    by_hash_.emplace(structs_[s].hash, s);
  }
}

const MessageSchemas& MessageSchemas::Hpdm() {
  static const MessageSchemas schemas(kLcmTexts, kLcmTextNames);
  return schemas;
}

MessageSchemas MessageSchemas::HpdmAnd(std::span<const std::string> texts,
                                       std::span<const std::string> names) {
  std::vector<std::string_view> all_texts(std::begin(kLcmTexts), std::end(kLcmTexts));
  std::vector<std::string> all_names(std::begin(kLcmTextNames), std::end(kLcmTextNames));
  all_texts.insert(all_texts.end(), texts.begin(), texts.end());
  all_names.insert(all_names.end(), names.begin(), names.end());
  return MessageSchemas(all_texts, all_names);
}

const LcmStruct* MessageSchemas::Find(std::span<const std::uint8_t> bytes) const {
  if (bytes.size() < kHashBytes) return nullptr;
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < kHashBytes; ++i) hash = hash << 8 | bytes[i];
  const auto found = by_hash_.find(static_cast<std::int64_t>(hash));
  return found == by_hash_.end() ? nullptr : &structs_[found->second];
}

bool MessageSchemas::Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                            const std::function<void(const MessageValue&)>& visit) const {
  Values values(visit);
  return Decode(type, bytes, &values);
}

bool MessageSchemas::Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                            MessageVisitor* visitor) const {
  return Walk(structs_, bytes, visitor).Message(type, nullptr);
}

bool MessageSchemas::Check(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                           MessageOrder* order) const {
  *order = {};
  return Walk(structs_, bytes, nullptr).Message(type, order);
}

std::string MessageSchemas::TypeOf(std::span<const std::uint8_t> bytes) const {
  if (const LcmStruct* type = Find(bytes)) return type->name;
  if (bytes.size() < kHashBytes) return "no LCM message";
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text = "0x";
  for (const std::uint8_t byte : bytes.first(kHashBytes)) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace hpdm
