#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

void EnsureSound(const MessageSchemas& schemas) {
  for (const LcmStruct& type : schemas.structs()) {
    for (std::size_t m = 0; m < type.members.size(); ++m) {
      const LcmMember& member = type.members[m];
      if (member.type == LcmPrimitive::kStruct) {
        HPDM_ENSURE(schemas.structs()[member.struct_index].name == member.type_name);
      }
      for (const LcmDimension& dimension : member.dimensions) {
        HPDM_ENSURE(dimension.constant >= 0 || dimension.member < m);
      }
    }
  }
}

/// Counts structures, which must be as many begun as ended in a message that is whole.
class Structure : public MessageVisitor {
 public:
  void BeginStruct() override { ++depth_; }
  void EndStruct() override { --depth_; }
  void BeginArray() override { ++depth_; }
  void EndArray() override { --depth_; }
  void Value(const MessageValue& value) override {
    HPDM_ENSURE(!value.name.empty());
    ++values_;
  }
  int depth() const { return depth_; }
  std::size_t values() const { return values_; }

 private:
  int depth_ = 0;
  std::size_t values_ = 0;
};

/// True if the body fits any type's message.
bool Decode(const MessageSchemas& schemas, Bytes body) {
  bool any = false;
  for (const LcmStruct& type : schemas.structs()) {
    std::vector<std::uint8_t> bytes(8);
    for (int i = 0; i < 8; ++i) {
      bytes[static_cast<std::size_t>(i)] =
          static_cast<std::uint8_t>(static_cast<std::uint64_t>(type.hash) >> (56 - 8 * i));
    }
    bytes.insert(bytes.end(), body.begin(), body.end());
    const LcmStruct* found = schemas.Find(bytes);
    HPDM_ENSURE(found != nullptr && found->hash == type.hash);
    MessageOrder order;
    Structure structure;
    const bool readable = schemas.Check(type, bytes, &order);
    HPDM_ENSURE(readable == schemas.Decode(type, bytes, &structure));
    HPDM_ENSURE(structure.values() <= bytes.size());
    HPDM_ENSURE(!readable || structure.depth() == 0);
    any |= readable;
  }
  return any;
}

}  // namespace

bool Schema(Bytes bytes) {
  const auto zero = std::find(bytes.begin(), bytes.end(), std::uint8_t{0});
  const auto text_bytes = static_cast<std::size_t>(zero - bytes.begin());
  const std::string_view texts[] = {Text(bytes.first(text_bytes))};
  const std::string names[] = {"types.lcm"};
  try {
    const MessageSchemas schemas(texts, names);
    EnsureSound(schemas);
    return Decode(schemas, bytes.subspan(std::min(text_bytes + 1, bytes.size())));
  } catch (const InputError& error) {
    EnsureOneLine(error, std::string_view(error.what()).starts_with("types.lcm:") ? "types.lcm:"
                                                                                  : "LCM type ");
    return false;
  }
}

}  // namespace hpdm::fuzz
