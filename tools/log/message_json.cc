#include "tools/log/message_json.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

class Writer : public MessageVisitor {
 public:
  Writer(std::string* json, MessageHeader* header) : json_(*json), header_(*header) {
    json_.clear();
    header_ = {};
  }

  void BeginStruct() override {
    Separate();
    json_ += '{';
    dimensions_.push_back(0);
  }
  void EndStruct() override {
    json_ += '}';
    dimensions_.pop_back();
  }
  void BeginMember(const LcmMember& member) override {
    Separate();
    json_ += '"';
    json_ += member.name;
    json_ += "\":";
    is_boolean_ = member.type == LcmPrimitive::kBoolean;
  }
  void BeginArray() override {
    if (dimensions_.back()++ > 0) return;
    Separate();
    json_ += '[';
  }
  void EndArray() override {
    if (--dimensions_.back() == 0) json_ += ']';
  }
  void Value(const MessageValue& value) override {
    Separate();
    if (const auto* integer = std::get_if<std::int64_t>(&value.value)) {
      if (dimensions_.size() == 1 && value.name == "sequence") header_.sequence = *integer;
      if (dimensions_.size() == 1 && value.name == "time_ns") header_.time_ns = *integer;
      if (is_boolean_) {
        json_ += *integer != 0 ? "true" : "false";
      } else {
        Number(*integer);
      }
    } else if (const auto* real = std::get_if<double>(&value.value)) {
      if (std::isfinite(*real)) {
        Number(*real);
      } else {
        json_ += std::isnan(*real) ? "\"NaN\"" : *real > 0 ? "\"Infinity\"" : "\"-Infinity\"";
      }
    } else {
      json_ += Json(std::get<std::string_view>(value.value))
                   .dump(-1, ' ', false, Json::error_handler_t::replace);
    }
  }

 private:
  void Separate() {
    if (json_.empty()) return;
    const char before = json_.back();
    if (before != '{' && before != '[' && before != ':') json_ += ',';
  }
  template <typename T>
  void Number(T number) {
    std::array<char, 32> digits;
    char* const end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    json_.append(digits.data(), end);
  }

  std::string& json_;
  MessageHeader& header_;
  std::vector<int> dimensions_;  // number of the member's open arrays, by struct
  bool is_boolean_ = false;
};

Json SchemaOf(const MessageSchemas& schemas, const LcmStruct& type,
              std::vector<const LcmStruct*>* within) {
  Json properties = Json::object();
  const bool recursive = std::find(within->begin(), within->end(), &type) != within->end();
  within->push_back(&type);
  for (const LcmMember& member : type.members) {
    if (recursive) break;
    Json value;
    switch (member.type) {
      case LcmPrimitive::kStruct:
        value = SchemaOf(schemas, schemas.structs()[member.struct_index], within);
        break;
      case LcmPrimitive::kString:
        value = {{"type", "string"}};
        break;
      case LcmPrimitive::kBoolean:
        value = {{"type", "boolean"}};
        break;
      case LcmPrimitive::kFloat:
      case LcmPrimitive::kDouble:
        value = {{"type", "number"}};
        break;
      default:
        value = {{"type", "integer"}};
    }
    if (!member.dimensions.empty()) {
      std::string shape;
      for (const LcmDimension& dimension : member.dimensions) shape += "[" + dimension.size + "]";
      value = {{"type", "array"}, {"items", value}, {"description", shape}};
    }
    properties[member.name] = value;
  }
  within->pop_back();
  return {{"type", "object"}, {"title", type.name}, {"properties", properties}};
}

}  // namespace

bool MessageToJson(const MessageSchemas& schemas, const LcmStruct& type,
                   std::span<const std::uint8_t> bytes, std::string* json, MessageHeader* header) {
  Writer writer(json, header);
  return schemas.Decode(type, bytes, &writer);
}

std::string JsonSchemaOf(const MessageSchemas& schemas, const LcmStruct& type) {
  std::vector<const LcmStruct*> within;
  return SchemaOf(schemas, type, &within).dump();
}

std::string Utf8(const std::string& text) {
  return Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace))
      .get<std::string>();
}

}  // namespace hpdm
