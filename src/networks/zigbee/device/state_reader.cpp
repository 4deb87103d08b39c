#include "networks/zigbee/device/state_reader.h"

#include <fmt/format.h>
#include <simdjson.h>

#include <cstring>
#include <vector>

#include "base/text.h"

namespace rubicon::networks::zigbee::device {

namespace {

namespace ondemand = simdjson::ondemand;

simdjson::error_code take_json(ondemand::value value, std::string_view& json) {
  ondemand::json_type type{};
  if (const auto error = value.type().get(type)) return error;
  switch (type) {
    case ondemand::json_type::object: {
      ondemand::object object;
      if (const auto error = value.get_object().get(object)) return error;
      return object.raw_json().get(json);
    }
    case ondemand::json_type::array: {
      ondemand::array array;
      if (const auto error = value.get_array().get(array)) return error;
      return array.raw_json().get(json);
    }
    default: json = value.raw_json_token(); return simdjson::SUCCESS;
  }
}

}  // namespace

struct StateReader::Impl {
  simdjson::error_code read(std::string_view payload) {
    const auto needed = payload.size() + simdjson::SIMDJSON_PADDING;
    if (buffer.size() < needed) buffer.resize(needed);
    std::memcpy(buffer.data(), payload.data(), payload.size());
    ondemand::document document;
    if (const auto error = parser.iterate(buffer.data(), payload.size(), buffer.size()).get(document)) return error;
    ondemand::object object;
    if (const auto error = document.get_object().get(object)) return error;
    for (auto field : object) {
      Member member;
      if (const auto error = field.unescaped_key().get(member.key)) return error;
      ondemand::value value;
      if (const auto error = field.value().get(value)) return error;
      if (const auto error = take_json(value, member.json)) return error;
      member.json = base::trimmed(member.json);
      if (members.size() == kMaxMembers) return simdjson::CAPACITY;
      members.push_back(member);
    }
    const bool at_end = document.current_location().error() == simdjson::OUT_OF_BOUNDS;
    return at_end ? simdjson::SUCCESS : simdjson::TRAILING_CONTENT;
  }

  ondemand::parser parser;
  std::vector<char> buffer;
  std::vector<Member> members;
};

StateReader::StateReader() : impl_(std::make_unique<Impl>()) {}
StateReader::~StateReader() = default;

Result<std::span<const Member>> StateReader::read(std::string_view payload) {
  impl_->members.clear();
  if (payload.size() > kMaxPayload) {
    return fail(ErrorCode::kOutOfRange, fmt::format("state: {} bytes, more than {}", payload.size(), kMaxPayload));
  }
  const auto error = impl_->read(payload);
  if (error == simdjson::CAPACITY)
    return fail(ErrorCode::kOutOfRange, fmt::format("state: more than {} members", kMaxMembers));
  if (error) return fail(ErrorCode::kInvalid, fmt::format("state: no JSON object: {}", simdjson::error_message(error)));
  return std::span<const Member>(impl_->members);
}

}  // namespace rubicon::networks::zigbee::device
