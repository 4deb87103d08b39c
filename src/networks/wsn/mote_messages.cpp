#include "networks/wsn/mote_messages.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "base/text.h"
#include "model/json_text.h"
#include "motes/learning_records.h"
#include "motes/mote_packet.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto slash = text.find('/');
    parts.push_back(text.substr(0, slash));
    if (slash == text.npos) return parts;
    text.remove_prefix(slash + 1);
  }
}

/// A number without leading zeros, so that each has one spelling.
template <class Number>
bool read_number(std::string_view text, Number& out) {
  const auto number = base::parse_number<Number>(text);
  if (!number || (text.size() > 1 && text[0] == '0')) return false;
  out = *number;
  return true;
}

bool read_net(const std::vector<std::string_view>& parts, MoteTag& tag) {
  if (parts.size() < 4 || parts.size() > 6) return false;
  if (!read_number(parts[1], tag.transport) || !read_number(parts[2], tag.application)) return false;
  if (!read_number(parts[3], tag.type)) return false;
  tag.reliable = parts.size() > 4;
  if (tag.reliable && parts[4] != "reliable") return false;
  return parts.size() < 6 || read_number(parts[5], tag.sequence.emplace());
}

}  // namespace

Result<MoteTag> parse_tag(std::string_view text) {
  const auto parts = parts_of(text);
  if (parts[0] != "mote" || parts.size() < 2)
    return fail(ErrorCode::kUnsupported, fmt::format("message type {}, expected mote/...", model::quoted(text)));
  MoteTag tag;
  if (parts[1] == "json" && (parts.size() == 2 || (parts.size() == 3 && parts[2] == "reliable"))) {
    tag.kind = MoteTag::Kind::kJson;
    tag.reliable = parts.size() == 3;
    return tag;
  }
  if (parts[1] == "am" && parts.size() == 3 && read_number(parts[2], tag.type)) {
    tag.kind = MoteTag::Kind::kAm;
    return tag;
  }
  if (read_net(parts, tag)) return tag;
  return fail(
      ErrorCode::kInvalid,
      fmt::format("message type {}, expected mote/<transport>/<application>/<record type>[/reliable[/<sequence>]], "
                  "mote/am/<type> or mote/json",
                  model::quoted(text)));
}

std::optional<std::uint16_t> mote_address(std::string_view device) {
  std::uint16_t address = 0;
  if (!read_number(device, address) || address == 0 || address >= motes::kBaseMote) return std::nullopt;
  return address;
}

std::optional<std::uint16_t> receiver_address(std::string_view device) {
  return device.empty() ? motes::kBroadcast : mote_address(device);
}

namespace {

using Json = nlohmann::ordered_json;
/// For texts of others: ordered_json searches all members for each one that it adds, which takes seconds for many.
using ParsedJson = nlohmann::json;

constexpr std::string_view kRecord = "record", kTransport = "transport", kApplication = "application";

/// The value of a member, shortened for an error text.
std::string shown(const ParsedJson& value) {
  constexpr std::size_t kShown = 40;
  if (value.is_structured()) return value.is_array() ? "an array" : "an object";
  return model::dump_ascii(value).substr(0, kShown);  // ASCII: the cut cannot split a character
}

tl::unexpected<Error> unfit(std::string_view record, std::string_view member, const ParsedJson& value,
                            std::string_view expected) {
  return fail(ErrorCode::kInvalid,
              fmt::format("mote record {}: {} is {}, expected {}", record, member, shown(value), expected));
}

Result<const motes::LearningRecord*> record_of(const ParsedJson& object) {
  if (!object.is_object()) return fail(ErrorCode::kInvalid, "a message to a mote is not a JSON object");
  const auto name = object.find(kRecord);
  if (name == object.end() || !name->is_string()) {
    return fail(ErrorCode::kInvalid, "a message to a mote has no \"record\", expected the name of a record");
  }
  const auto* record = motes::find_learning_record(name->get_ref<const std::string&>());
  if (record == nullptr) {
    std::string known;
    for (const auto& one : motes::learning_records()) known += fmt::format("{}{}", known.empty() ? "" : ", ", one.name);
    return fail(ErrorCode::kNotFound, fmt::format("unknown mote record {}, expected one of {}", shown(*name), known));
  }
  if (record->own_packet) {
    return fail(ErrorCode::kUnsupported, fmt::format("mote record {}: is a packet of its own (type {}), "
                                                     "not part of a radio message",
                                                     record->name, record->type));
  }
  return record;
}

/// `transport` or `application`: the member if given, otherwise the usual one of the record.
Result<std::uint8_t> component_of(const motes::LearningRecord& record, const ParsedJson& object,
                                  std::string_view member, std::uint8_t usual) {
  const auto given = object.find(member);
  if (given != object.end()) {
    const bool fits = given->is_number_unsigned() && *given >= 1 && *given <= 0xff;
    if (!fits) return unfit(record.name, member, *given, "a whole number from 1 to 255");
    return given->get<std::uint8_t>();
  }
  if (usual != 0) return usual;
  return fail(ErrorCode::kInvalid,
              fmt::format("mote record {}: {} is missing, expected 1 to 255", record.name, member));
}

Result<std::vector<double>> numbers_of(const motes::LearningRecord& record, const std::string& member,
                                       const ParsedJson& value) {
  if (value.is_number()) return std::vector<double>{value.get<double>()};
  const auto* field = record.find(member);
  if (field == nullptr) return std::vector<double>{};  // encode_learning() refuses it and lists the names
  if (!value.is_array() || !field->is_array())
    return unfit(record.name, member, value, field->is_array() ? "an array of numbers" : "a number");
  std::vector<double> numbers;
  for (const ParsedJson& element : value) {
    if (!element.is_number()) return unfit(record.name, member + "[]", element, "a number");
    numbers.push_back(element.get<double>());
  }
  return numbers;
}

Result<motes::FieldValues> fields_of(const motes::LearningRecord& record, const ParsedJson& object) {
  motes::FieldValues fields;
  for (const auto& [member, value] : object.items()) {
    if (member == kRecord || member == kTransport || member == kApplication) continue;
    auto numbers = numbers_of(record, member, value);
    if (!numbers) return fail(numbers.error());
    fields.insert_or_assign(member, std::move(*numbers));
  }
  return fields;
}

/// The shortest decimal that converts to the same float: 0.1, not 0.10000000149011612. That of the largest float
/// exceeds the range of floats.
double shortest(double number) {
  const auto single = static_cast<float>(number);
  const double decimal = std::strtod(fmt::format("{}", single).c_str(), nullptr);
  const bool fits = std::abs(decimal) <= std::numeric_limits<float>::max();
  return fits && static_cast<float>(decimal) == single ? decimal : number;
}

Json json_of(const motes::RecordField& field, const std::vector<double>& numbers) {
  Json array = Json::array();
  for (const double number : numbers) {
    if (field.kind == motes::FieldKind::kFloat)
      array.push_back(shortest(number));
    else
      array.push_back(static_cast<std::int64_t>(number));
  }
  return field.is_array() ? array : array.front();
}

}  // namespace

Result<LearningMessage> learning_message(std::string_view json) {
  const auto object = model::parse_json(json);
  if (object.is_discarded()) return fail(ErrorCode::kInvalid, "a message to a mote is not valid JSON");
  const auto record = record_of(object);
  if (!record) return fail(record.error());
  const auto transport = component_of(**record, object, kTransport, (*record)->transport);
  if (!transport) return fail(transport.error());
  const auto application = component_of(**record, object, kApplication, (*record)->application);
  if (!application) return fail(application.error());
  const auto fields = fields_of(**record, object);
  if (!fields) return fail(fields.error());
  auto bytes = motes::encode_learning((*record)->name, *fields);
  if (!bytes) return fail(bytes.error());
  return LearningMessage{*transport, *application, std::move(*bytes)};
}

std::optional<std::string> learning_json(const motes::NetMessage& message) {
  const auto* record = motes::learning_record_in(message);
  if (record == nullptr) return std::nullopt;
  const auto fields = motes::decode_learning(*record, message.record);
  if (!fields) return std::nullopt;
  Json object;
  object[std::string(kRecord)] = record->name;
  for (const motes::RecordField& field : record->fields)
    object[std::string(field.name)] = json_of(field, fields->find(field.name)->second);
  return model::dump(object);
}

}  // namespace rubicon::networks::wsn
