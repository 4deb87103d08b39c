#include "networks/wsn/mote_tag.h"

#include <fmt/format.h>

#include <vector>

#include "base/text.h"
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

}  // namespace rubicon::networks::wsn
