#include "networks/zigbee/bridge/list_slices.h"

#include <fmt/format.h>
#include <simdjson.h>

#include "networks/zigbee/bridge/device_record.h"

namespace rubicon::networks::zigbee::bridge {
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

std::string ListSlices::take_text() {
  parsed_.reset();
  return std::move(list_);
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
