#include "lcmtypes/wire/message_walk.h"

#include <bit>
#include <string>
#include <string_view>

#include "lcmtypes/wire/message_hash.h"

namespace hpdm {
namespace {

/// Returns the bytes of one value; 0 for types of variable size.
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
        index_ = 0;
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
        index_ = static_cast<std::size_t>(i);
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
    if (visitor_ != nullptr) unit_ = member.Unit(index_);
    switch (member.type) {
      case LcmPrimitive::kStruct:
        return Struct(structs_[member.struct_index], depth + 1);
      case LcmPrimitive::kString:
        return String();
      case LcmPrimitive::kFloat: {
        std::uint64_t bits = 0;
        if (!Big(4, &bits)) return false;
        Report(static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits))));
        return true;
      }
      case LcmPrimitive::kDouble: {
        std::uint64_t bits = 0;
        if (!Big(8, &bits)) return false;
        Report(std::bit_cast<double>(bits));
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
    Report(*integer);
    return true;
  }

  bool String() {
    std::uint64_t length = 0;  // with the final zero
    if (!Big(4, &length) || length == 0 || length > bytes_.size() - at_) return false;
    if (bytes_[at_ + length - 1] != 0) return false;
    Report(std::string_view(reinterpret_cast<const char*>(bytes_.data() + at_), length - 1));
    at_ += length;
    return true;
  }

  template <typename Value>
  void Report(Value value) const {
    if (visitor_ != nullptr) visitor_->Value({name_, value, unit_});
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
  std::size_t index_ = 0;  // of the element in its array
  std::string_view unit_;
};

}  // namespace

bool WalkMessage(const std::vector<LcmStruct>& structs, const LcmStruct& type,
                 std::span<const std::uint8_t> bytes, MessageVisitor* visitor,
                 MessageOrder* order) {
  return Walk(structs, bytes, visitor).Message(type, order);
}

}  // namespace hpdm
