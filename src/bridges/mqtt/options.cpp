#include "bridges/mqtt/mqtt_bridge.h"

#include <fmt/format.h>

#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

namespace {

constexpr std::size_t kMaxBase = 64;
std::string base_fault(std::string_view base) {
  if (base.empty() || base.size() > kMaxBase) return "expected 1 to 64 bytes";
  if (base.find_first_of("+#") != base.npos || base.starts_with('/') || base.ends_with('/') ||
      base.find("//") != base.npos)
    return "expected levels joined by /, without + and #";
  if (base.starts_with('$')) return "topics with $ are the broker's own";
  return {};
}

void read_base(ConfigReader& options, Options& found) {
  found.base = options.text("base", found.base);
  auto fault = base_fault(found.base);
  if (found.base == "rubicon-space" || found.base.starts_with("rubicon-space/"))
    fault = "is where components meet at a broker (docs/sites.md)";
  if (found.base.starts_with("homeassistant")) fault = "is where Home Assistant expects announcements";
  if (!fault.empty()) options.error("base", fmt::format("is '{}': {}", found.base, fault));
  found.discovery_base = options.text("discovery-base", found.discovery_base);
  if (const auto wrong = base_fault(found.discovery_base); !wrong.empty()) options.error("discovery-base", wrong);
}

/// `passive`, `on-request`, or {active: [patterns]}.
void read_demand(ConfigReader& options, Options& found) {
  const auto* node = options.node("demand");
  if (node == nullptr) return;
  if (node->kind == ConfigNode::Kind::kMap) {
    auto demand = options.map("demand");
    found.active = read_keys(demand, "active");
    return demand.finish();
  }
  found.on_request = options.choice("demand", "passive", {"passive", "on-request"}) == "on-request";
}

}  // namespace

Options read_options(ConfigReader& options, const std::string& directory) {
  Options found;
  found.origin = "broker";
  found.broker = transport::read_mqtt_broker(options, directory);
  read_base(options, found);
  read_scope(options, found);
  read_demand(options, found);
  const auto form = options.choice("discovery", "none", {"none", "homeassistant", "homeassistant-entities"});
  found.discovery = form == "none"            ? Discovery::kNone
                    : form == "homeassistant" ? Discovery::kDevices
                                              : Discovery::kEntities;
  found.json = options.choice("payload", "text", {"text", "json"}) == "json";
  found.friendly = options.choice("names", "keys", {"keys", "friendly"}) == "friendly";
  found.attributes = options.boolean("attributes", false);
  found.keep = options.boolean("keep", false);
  found.page = options.text("page", {});
  if (!found.page.empty() && !found.page.starts_with("http://") && !found.page.starts_with("https://"))
    options.error("page", "expected the address of the page: http://HOST:PORT or https://HOST:PORT");
  if (found.json && found.discovery != Discovery::kNone)
    options.error("payload",
                  "json is for databases, expected text where there is a discovery; a second bridge may "
                  "have the other");
  return found;
}

}  // namespace rubicon::bridges::mqtt
