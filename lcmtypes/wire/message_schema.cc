#include "lcmtypes/wire/message_schema.h"

#include <algorithm>
#include <bit>

#include "engine/base/error.h"
#include "engine/base/quoted_token.h"
#include "lcmtypes/lcm_texts.h"
#include "lcmtypes/wire/message_hash.h"
#include "lcmtypes/wire/message_schema_parser.h"
#include "lcmtypes/wire/message_walk.h"

namespace hpdm {
namespace {

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
    for (LcmStruct& type : ParseLcmTypes(texts[t], names[t])) structs_.push_back(std::move(type));
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

void MessageSchemas::LinkFormerTypes() {
  for (const FormerType& former : kFormerTypes) {
    const std::string name = "hpdm." + std::string(former.name);
    for (std::size_t s = 0; s < structs_.size(); ++s) {
      if (structs_[s].name == name) by_hash_.emplace(static_cast<std::int64_t>(former.hash), s);
    }
  }
}

const MessageSchemas& MessageSchemas::Hpdm() {
  static const MessageSchemas schemas = HpdmAnd({}, {});
  return schemas;
}

MessageSchemas MessageSchemas::HpdmAnd(std::span<const std::string> texts,
                                       std::span<const std::string> names) {
  std::vector<std::string_view> all_texts(std::begin(kLcmTexts), std::end(kLcmTexts));
  std::vector<std::string> all_names(std::begin(kLcmTextNames), std::end(kLcmTextNames));
  all_texts.insert(all_texts.end(), texts.begin(), texts.end());
  all_names.insert(all_names.end(), names.begin(), names.end());
  MessageSchemas schemas(all_texts, all_names);
  schemas.LinkFormerTypes();
  return schemas;
}

const LcmStruct* MessageSchemas::Find(std::span<const std::uint8_t> bytes) const {
  if (bytes.size() < kHashBytes) return nullptr;
  const auto found = by_hash_.find(static_cast<std::int64_t>(HashOf(bytes)));
  return found == by_hash_.end() ? nullptr : &structs_[found->second];
}

bool MessageSchemas::Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                            const std::function<void(const MessageValue&)>& visit) const {
  Values values(visit);
  return Decode(type, bytes, &values);
}

bool MessageSchemas::Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                            MessageVisitor* visitor) const {
  return WalkMessage(structs_, type, bytes, visitor, nullptr);
}

bool MessageSchemas::Check(const LcmStruct& type, std::span<const std::uint8_t> bytes,
                           MessageOrder* order) const {
  *order = {};
  return WalkMessage(structs_, type, bytes, nullptr, order);
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
