#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace hpdm {

/// Layout of LCM message types, read from .lcm files, for programs that show or convert messages of
/// any type (lcm-gen's classes have no reflection). A message is the hash of its type (8 bytes) and
/// then its members in order, big-endian.

/// One value of a decoded message: "tools[0].joints[2]". Bytes, integers and booleans are integers.
struct MessageValue {
  std::string_view name;  ///< Valid during the call only.
  std::variant<std::int64_t, double, std::string_view> value;
  std::string_view unit = {};  ///< From the comment beside the member; empty: none.
};

/// Position of a message among the others of its channel: its integer members of these names.
struct MessageOrder {
  std::optional<std::int64_t> sequence;  ///< Empty if the type has none.
  std::int64_t instrument = 0;           ///< Sequences are counted for each; else 0.
};

enum class LcmPrimitive : std::uint8_t {
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kByte,
  kFloat,
  kDouble,
  kString,
  kBoolean,
  kStruct
};

struct LcmDimension {
  std::string size;            ///< Text: a number, or the member that holds the count.
  std::int64_t constant = -1;  ///< The number; -1 if a member holds the count.
  std::size_t member = 0;      ///< Index of that member in the same struct, before this one.
};

struct LcmMember {
  std::string name;
  std::string type_name;  ///< A struct's with its package.
  LcmPrimitive type = LcmPrimitive::kStruct;
  std::size_t struct_index = 0;  ///< Index of the struct, if it is one.
  std::vector<LcmDimension> dimensions = {};
  std::vector<std::string> units = {};  ///< As CommentUnits returns them.

  /// Returns the unit of the element with the last index `index`; empty: none.
  std::string_view Unit(std::size_t index) const {
    if (units.size() == 1) return units[0];
    return index < units.size() ? std::string_view(units[index]) : std::string_view();
  }
};

struct LcmStruct {
  std::string name;  ///< With its package: "hpdm.tool_t".
  std::vector<LcmMember> members = {};
  std::int64_t hash = 0;  ///< First 8 bytes of a message of this type.
};

/// Visits a message from its first value to its last, with its structure. A struct's members come
/// in order, each announced before its value, its struct or its array; an array has an inner array
/// for every further dimension.
class MessageVisitor {
 public:
  virtual ~MessageVisitor() = default;
  virtual void BeginStruct() {}
  virtual void EndStruct() {}
  virtual void BeginMember(const LcmMember&) {}
  virtual void BeginArray() {}
  virtual void EndArray() {}
  virtual void Value(const MessageValue& value) = 0;
};

/// A set of message types. Filled by one thread; afterwards any thread may decode.
class MessageSchemas {
 public:
  /// Reads .lcm texts, all together since they may name each other's structs. `names` name the
  /// texts in error messages. Throws InputError (name, line, fault, remedy), also for arrays of
  /// more than 16 dimensions and structs inside structs without end.
  MessageSchemas(std::span<const std::string_view> texts, std::span<const std::string> names);

  /// Returns the types of this package. They include messages of version 0.1 (message_hash.h).
  static const MessageSchemas& Hpdm();
  /// Returns the same types and those of further texts.
  static MessageSchemas HpdmAnd(std::span<const std::string> texts,
                                std::span<const std::string> names);

  const std::vector<LcmStruct>& structs() const { return structs_; }
  /// Returns the type of the message by its hash; null if it is not known.
  const LcmStruct* Find(std::span<const std::uint8_t> bytes) const;

  /// Calls `visit` with every value of a message of type `type`, in order. False if the bytes are
  /// not exactly one message of it; some values may have been visited then. Trusts no length; the
  /// cost is bounded by the bytes.
  bool Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
              const std::function<void(const MessageValue&)>& visit) const;
  /// The same with the message's structure.
  bool Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
              MessageVisitor* visitor) const;

  /// Returns the name of the message's type, or its hash in hexadecimal if the type is not known,
  /// or "no LCM message" if the bytes are too few for a hash.
  std::string TypeOf(std::span<const std::uint8_t> bytes) const;

  /// True if the bytes are exactly one message of type `type`. Sets `order` to its position among
  /// the others. Skips arrays of numbers, so the cost does not depend on their lengths.
  bool Check(const LcmStruct& type, std::span<const std::uint8_t> bytes, MessageOrder* order) const;

 private:
  void Link();
  void LinkFormerTypes();

  std::vector<LcmStruct> structs_;
  std::map<std::int64_t, std::size_t> by_hash_;
};

}  // namespace hpdm
