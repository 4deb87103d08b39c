#include "proxy/admission/roaming_claim.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "proxy/tuple_text.h"
#include "rubicon/key.hpp"

namespace rubicon::proxy::admission {

namespace {

using PlainTree = nlohmann::json;

constexpr std::size_t kMaxClaim = 4096;
constexpr std::size_t kMaxAddress = 255;
/// 2200-01-01 in seconds since 1970: microseconds up to it are exact in a double.
constexpr double kLatest = 7258118400.0;

bool is_part(const std::string& text) {
  return text == model::to_key_part(text);
}

Error wrong(std::string_view what) {
  return {ErrorCode::kInvalid, fmt::format("a roaming claim needs {}", what)};
}

}  // namespace

bool better(const Claim& one, const Claim& other) {
  return std::tie(other.since, one.island, one.network) < std::tie(one.since, other.island, other.network);
}

std::string claim_text(const Claim& claim) {
  std::string out = fmt::format("{{\"key\":\"{}\",\"network\":\"{}\",\"device\":\"{}\",\"address\":", claim.key,
                                claim.network, claim.device);
  model::append_json(claim.address, out);
  out += ",\"since\":";
  model::append_seconds(claim.since, out);
  out += fmt::format(",\"reachable\":{}}}", claim.reachable);
  return out;
}

Result<Claim> parse_claim(OwnerId island, std::string_view text) {
  const auto tree = text.size() > kMaxClaim ? PlainTree(PlainTree::value_t::discarded) : model::parse_json(text);
  if (!tree.is_object()) return fail(wrong("a JSON object of at most 4096 bytes"));
  const auto key = model::find_text(tree, "key"), network = model::find_text(tree, "network"),
             device = model::find_text(tree, "device"), address = model::find_text(tree, "address");
  if (!key || !model::check_key(*key)) return fail(wrong("the key of the device"));
  if (!network || !device || !is_part(*network) || !is_part(*device)) {
    return fail(wrong("the key parts of network and device"));
  }
  if (!address || address->empty() || address->size() > kMaxAddress) {
    return fail(wrong("an address of 1 to 255 bytes"));
  }
  const auto since = tree.find("since");
  const double seconds = since != tree.end() && since->is_number() ? since->get<double>() : -1;
  if (!(seconds >= 0 && seconds <= kLatest)) return fail(wrong("since, in seconds from 1970 to 2200"));
  const auto reachable = tree.find("reachable");
  const bool heard = reachable != tree.end() && reachable->is_boolean() && reachable->get<bool>();
  return Claim{island,  *key,     *network,
               *device, *address, WallTime(std::chrono::microseconds(std::llround(seconds * 1e6))),
               heard};
}

std::string claim_key(const Identity& identity) {
  return fmt::format("ROAMING.{}.{}", identity.domain, model::to_key_part(identity.address));
}

bool is_claim_key(std::string_view key, const Identity& identity) {
  const auto first = claim_key(identity);
  if (!key.starts_with(first)) return false;
  key.remove_prefix(first.size());
  if (key.empty()) return true;
  const auto twin = key.front() == '-' ? base::parse_number<std::uint32_t>(key.substr(1)) : std::nullopt;
  return twin && *twin >= 2;
}

}  // namespace rubicon::proxy::admission
