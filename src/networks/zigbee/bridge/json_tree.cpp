#include "networks/zigbee/bridge/json_tree.h"

#include <fmt/format.h>
#include <simdjson.h>

#include <algorithm>
#include <limits>

#include "base/text.h"
#include "model/json_members.h"
#include "networks/zigbee/bridge/device_record.h"

namespace rubicon::networks::zigbee::bridge {

Result<JsonElement> JsonTree::parse(std::string_view text, std::string_view subject, std::size_t most_bytes) {
  if (text.size() > most_bytes)
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} bytes, more than {}", subject, text.size(), most_bytes));
  JsonElement root;
  auto error = parser_.allocate(std::max(text.size(), std::size_t{32}), kMaxJsonDepth);
  if (!error) error = parser_.parse(text.data(), text.size()).get(root);
  if (error) return fail(ErrorCode::kInvalid, fmt::format("{}: {}", subject, simdjson::error_message(error)));
  return root;
}

Result<JsonObject> JsonTree::parse_object(std::string_view text, std::string_view subject, std::size_t most_bytes) {
  const auto root = parse(text, subject, most_bytes);
  if (!root) return fail(root.error());
  JsonObject object;
  if (root->get(object)) return fail(ErrorCode::kInvalid, fmt::format("{}: no JSON object", subject));
  return object;
}

std::optional<JsonElement> member(const JsonObject& object, std::string_view name) {
  JsonElement found;
  if (object.at_key(name).get(found) || found.is_null()) return std::nullopt;
  return found;
}

std::optional<JsonObject> object_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  JsonObject inner;
  if (!found || found->get(inner)) return std::nullopt;
  return inner;
}

std::optional<JsonArray> array_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  JsonArray inner;
  if (!found || found->get(inner)) return std::nullopt;
  return inner;
}

std::string text_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  std::string_view text;
  if (!found || found->get(text)) return {};
  if (text.size() > kMaxTextBytes) text = text.substr(0, base::utf8_prefix(text.substr(0, kMaxTextBytes)));
  return std::string(text);
}

std::string word_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  if (!found) return {};
  return found->is_string() ? text_at(object, name) : json_at(object, name).substr(0, kMaxTextBytes);
}

std::optional<bool> flag_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  bool flag = false;
  if (!found || found->get(flag)) return std::nullopt;
  return flag;
}

double number_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  double number = 0;
  return found && !found->get(number) ? number : 0;
}

std::uint64_t count_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  std::uint64_t count = 0;
  return found && !found->get(count) ? count : 0;
}

std::uint32_t small_count_at(const JsonObject& object, std::string_view name) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count_at(object, name), std::numeric_limits<std::uint32_t>::max()));
}

WallTime milliseconds_at(const JsonObject& object, std::string_view name) {
  return model::time_from_seconds(number_at(object, name) / 1e3);
}

std::string json_at(const JsonObject& object, std::string_view name) {
  const auto found = member(object, name);
  return found ? simdjson::to_string(*found) : std::string();
}

namespace {

namespace ondemand = simdjson::ondemand;

tl::unexpected<Error> unreadable_list(simdjson::error_code error) {
  return fail(ErrorCode::kInvalid, fmt::format("bridge/devices: {}", simdjson::error_message(error)));
}

static_assert(ListSlices::kPadding >= simdjson::SIMDJSON_PADDING);

simdjson::padded_string_view padded(std::string& text) {
  text.reserve(text.size() + ListSlices::kPadding);
  return simdjson::padded_string_view(text.data(), text.size(), text.capacity());
}

}  // namespace

struct ListSlices::Parsed {
  ondemand::parser parser;
  ondemand::document document;
  ondemand::array_iterator at, end;
};

ListSlices::ListSlices(std::string list) : list_(std::move(list)), parsed_(std::make_unique<Parsed>()) {}
ListSlices::~ListSlices() = default;

Result<void> ListSlices::open() {
  auto& [parser, document, at, end] = *parsed_;
  ondemand::array records;
  auto error = parser.iterate(padded(list_)).get(document);
  if (!error) error = document.get_array().get(records);
  if (!error) error = records.begin().get(at);
  if (!error) error = records.end().get(end);
  if (error) return unreadable_list(error);
  return {};
}

Result<std::optional<std::string_view>> ListSlices::next() {
  auto& [parser, document, at, end] = *parsed_;
  if (!(at != end)) {
    const char* rest = nullptr;
    if (!document.current_location().get(rest))
      return fail(ErrorCode::kInvalid, "bridge/devices: text behind the list");
    return std::optional<std::string_view>();
  }
  ondemand::value item;
  if (const auto error = (*at).get(item)) return unreadable_list(error);
  std::string_view record;
  ondemand::object object;
  auto error = item.get_object().get(object);
  if (!error) error = object.raw_json().get(record);
  if (error && error != simdjson::INCORRECT_TYPE) return unreadable_list(error);
  ++at;
  return std::optional(record);
}

std::string address_in(std::string_view record) {
  std::string text(record);
  ondemand::parser parser;
  ondemand::document document;
  std::string_view address;
  if (parser.iterate(padded(text)).get(document)) return {};
  if (document.find_field_unordered("ieee_address").get(address)) return {};
  return address_of(address);
}

}  // namespace rubicon::networks::zigbee::bridge
