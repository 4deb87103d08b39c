#include "networks/knx/line/found_server.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace rubicon::networks::knx::line {

namespace {

template <std::size_t size>
bool is_set(const std::array<std::uint8_t, size>& bytes) {
  return bytes != std::array<std::uint8_t, size>{};
}

void merge_families(std::vector<wire::FamilyVersion>& into, const std::vector<wire::FamilyVersion>& more) {
  for (const auto& family : more) {
    const auto known =
        std::find_if(into.begin(), into.end(), [&](const auto& one) { return one.family == family.family; });
    if (known == into.end()) {
      into.push_back(family);
    } else {
      known->version = std::max(known->version, family.version);
    }
  }
}

std::string families_text(const std::vector<wire::FamilyVersion>& families) {
  std::vector<std::string> words;
  words.reserve(families.size());
  for (const auto& [family, version] : families) words.push_back(fmt::format("{} {}", to_string(family), version));
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string slot_text(const wire::TunnelSlot& slot) {
  const auto* state = !slot.usable ? "not usable" : slot.free ? "free" : "used";
  return fmt::format("{} {}{}", to_string(slot.address), state, slot.authorised ? "" : " (needs authorisation)");
}

std::string slots_text(const FoundServer& server) {
  const auto& slots = server.description.slots;
  std::vector<std::string> words;
  words.reserve(slots.size());
  for (const auto& slot : slots) words.push_back(slot_text(slot));
  return fmt::format("{} of {} free: {}", server.free_slots(), slots.size(), fmt::join(words, ", "));
}

/// What to configure where plain connections are refused.
std::string remedy_text(const wire::ServerDescription& about) {
  const auto secured = [&](wire::Family family) {
    return std::any_of(about.secured.begin(), about.secured.end(),
                       [&](const auto& one) { return one.family == family; });
  };
  const bool tunnelling = secured(wire::Family::kTunnelling), routing = secured(wire::Family::kRouting);
  if (!tunnelling && !routing) return "KNX IP Secure is required";
  return fmt::format("KNX IP Secure is required: configure {}`keyring: FILE.knxkeys`",
                     tunnelling ? "`via: tunnel-tcp` and " : "");
}

std::string security_text(const FoundServer& server) {
  switch (server.security()) {
    case Security::kRequired:
      return fmt::format("{} ({})", families_text(server.description.secured), remedy_text(server.description));
    case Security::kPossible: return "possible, not required";
    case Security::kNone: return "not required";
    case Security::kUnknown: break;
  }
  return {};
}

std::string mac_text(const std::array<std::uint8_t, 6>& mac) {
  return fmt::format("{:02x}", fmt::join(mac, ":"));
}

}  // namespace

std::size_t FoundServer::free_slots() const {
  return static_cast<std::size_t>(std::count_if(description.slots.begin(), description.slots.end(),
                                                [](const auto& slot) { return slot.usable && slot.free; }));
}

Security FoundServer::security() const {
  if (!description.secured.empty()) return Security::kRequired;
  if (!extended) return Security::kUnknown;
  return description.version(wire::Family::kSecurity) != 0 ? Security::kPossible : Security::kNone;
}

std::string_view to_string(Security security) {
  switch (security) {
    case Security::kUnknown: break;
    case Security::kNone: return "none";
    case Security::kPossible: return "possible";
    case Security::kRequired: return "required";
  }
  return "unknown";
}

void merge(wire::ServerDescription& into, const wire::ServerDescription& more) {
  if (more.medium != 0) {  // the answer describes the device
    into.medium = more.medium;
    into.programming_mode = more.programming_mode;
    into.address = more.address;
    into.project = more.project;
  }
  if (is_set(more.serial)) into.serial = more.serial;
  if (is_set(more.mac)) into.mac = more.mac;
  if (is_set(more.multicast)) into.multicast = more.multicast;
  if (!more.name.empty()) into.name = more.name;
  merge_families(into.families, more.families);
  merge_families(into.secured, more.secured);
  if (!more.addresses.empty()) into.addresses = more.addresses;
  if (more.max_apdu) into.max_apdu = more.max_apdu;
  if (!more.slots.empty()) into.slots = more.slots;
}

bool FoundServers::add(const transport::Endpoint& control, const wire::ServerDescription& description, bool extended) {
  auto known = std::find_if(servers_.begin(), servers_.end(), [&](const auto& one) { return one.control == control; });
  if (known == servers_.end()) {
    if (servers_.size() >= kMaxServers) return false;
    known = servers_.insert(servers_.end(), FoundServer{control, {}, false});
  }
  merge(known->description, description);
  known->extended = known->extended || extended;
  return true;
}

std::string medium_name(std::uint8_t medium) {
  switch (medium) {
    case 0x00: return "unknown medium";
    case 0x02: return "TP1";
    case 0x04: return "PL110";
    case 0x10: return "RF";
    case 0x20: return "IP";
    default: return fmt::format("medium {:02x}", medium);
  }
}

std::string describe(const FoundServer& server) {
  const auto& about = server.description;
  auto text = fmt::format("{}  {}  {}  {}{}", about.name.empty() ? "(no name)" : about.name, to_string(server.control),
                          to_string(about.address), medium_name(about.medium),
                          about.programming_mode ? "  in programming mode" : "");
  const auto line = [&](std::string_view what, const std::string& value) {
    text += fmt::format("\n  {:<10} {}", what, value);
  };
  if (is_set(about.serial)) line("serial", base::to_hex(about.serial));
  if (is_set(about.mac)) line("MAC", mac_text(about.mac));
  if (is_set(about.multicast)) line("group", fmt::format("{}", fmt::join(about.multicast, ".")));
  if (!about.families.empty()) line("families", families_text(about.families));
  if (const auto secure = security_text(server); !secure.empty()) line("secure", secure);
  if (about.max_apdu) line("max APDU", fmt::format("{} bytes", *about.max_apdu));
  if (!about.slots.empty()) line("tunnels", slots_text(server));
  if (about.slots.empty() && !about.addresses.empty()) {
    std::vector<std::string> words;
    words.reserve(about.addresses.size());
    for (const auto address : about.addresses) words.push_back(to_string(address));
    line("addresses", fmt::format("{}", fmt::join(words, ", ")));
  }
  return text;
}

}  // namespace rubicon::networks::knx::line
