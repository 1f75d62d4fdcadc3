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

/// Layout of LCM message types, as .lcm files tell it, for programs that show or convert messages
/// whatever their type (lcm-gen's classes have no reflection). One message is the hash of its type
/// (8 bytes), then its members in order, big-endian.

/// One value of a decoded message: "tools[0].joints[2]". Bytes, integers and booleans are integers.
struct MessageValue {
  std::string_view name;  ///< Valid during the call only.
  std::variant<std::int64_t, double, std::string_view> value;
};

/// What places a message among the others of its channel: its integer members of these names.
struct MessageOrder {
  std::optional<std::int64_t> sequence;  ///< Empty: the type has none.
  std::int64_t instrument = 0;           ///< Sequences are counted for each; 0 without.
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
  std::string size;            ///< As written: a number, or the member that holds the count.
  std::int64_t constant = -1;  ///< The number; -1 for a member's.
  std::size_t member = 0;      ///< Of the same struct, before this one.
};

struct LcmMember {
  std::string name;
  std::string type_name;  ///< With its package, of a struct.
  LcmPrimitive type = LcmPrimitive::kStruct;
  std::size_t struct_index = 0;  ///< Of a struct.
  std::vector<LcmDimension> dimensions = {};
};

struct LcmStruct {
  std::string name;  ///< With its package: "hpdm.tool_t".
  std::vector<LcmMember> members = {};
  std::int64_t hash = 0;  ///< As a message of this type begins.
};

/// Follows a message from its first value to its last, with its structure. A struct's members come
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
  /// Reads .lcm texts, all together since they may name each other's structs. `names` stand for the
  /// texts in messages. Throws InputError (name, line, what, remedy), also of types that no message
  /// needs: arrays of more than 16 dimensions, structs inside structs without end.
  MessageSchemas(std::span<const std::string_view> texts, std::span<const std::string> names);

  /// The types of this package. Messages of former versions are of them too (message_hash.h).
  static const MessageSchemas& Hpdm();
  /// The same with further texts.
  static MessageSchemas HpdmAnd(std::span<const std::string> texts,
                                std::span<const std::string> names);

  const std::vector<LcmStruct>& structs() const { return structs_; }
  /// The type whose messages begin as these bytes do; null when none is known.
  const LcmStruct* Find(std::span<const std::uint8_t> bytes) const;

  /// Calls `visit` with every value of a message of type `type`, in order. False when the bytes are
  /// not exactly one message of it: then some values may have been visited. Trusts no length; the
  /// cost is bounded by the bytes.
  bool Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
              const std::function<void(const MessageValue&)>& visit) const;
  /// The same with the message's structure.
  bool Decode(const LcmStruct& type, std::span<const std::uint8_t> bytes,
              MessageVisitor* visitor) const;

  /// What to call the type of these bytes: its name; its hash in hexadecimal where it is not known,
  /// "no LCM message" where there is none.
  std::string TypeOf(std::span<const std::uint8_t> bytes) const;

  /// Whether the bytes are exactly one message of type `type`, and its place among the others.
  /// Steps over arrays of numbers, so that its cost does not depend on their lengths.
  bool Check(const LcmStruct& type, std::span<const std::uint8_t> bytes, MessageOrder* order) const;

 private:
  void Link();
  void LinkFormerTypes();

  std::vector<LcmStruct> structs_;
  std::map<std::int64_t, std::size_t> by_hash_;
};

}  // namespace hpdm
