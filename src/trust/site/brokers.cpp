#include "trust/site/brokers.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/host_port.h"
#include "base/json_depth.h"
#include "base/printable.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::trust::site {

namespace {

using Json = nlohmann::json;

constexpr const char* kBrokersFile = "ca/brokers";
constexpr std::size_t kMaxBrokerList = 64UL * 1024;
constexpr std::size_t kBrokerLevels = 3;
constexpr mode_t kBrokersMode = 0600;
constexpr std::uint16_t kDefaultPort = 8883;

Json json_of(const BrokerFolder& one) {
  const auto& setup = one.setup;
  return {{"folder", setup.folder}, {"unit", one.unit},   {"state", setup.state},
          {"user", setup.user},     {"port", setup.port}, {"passwords", setup.takes_passwords}};
}

std::optional<BrokerFolder> folder_in(const Json& json) {
  const auto port = model::count_of(json, "port");
  BrokerFolder one{{model::text_of(json, "folder"), model::text_of(json, "state"), model::text_of(json, "user"),
                    static_cast<std::uint16_t>(port), model::flag_of(json, "passwords")},
                   model::text_of(json, "unit")};
  if (one.setup.folder.empty() || one.setup.state.empty() || port == 0 || port > 0xffff) return {};
  return one;
}

std::optional<BrokerList> list_in(const Json& json) {
  const auto hosts = json.is_object() ? json.find("hosts") : json.end();
  const auto folders = json.is_object() ? json.find("folders") : json.end();
  if (!json.is_object() || hosts == json.end() || folders == json.end() || !hosts->is_array() || !folders->is_array())
    return {};
  BrokerList list;
  for (const auto& host : *hosts) {
    if (!host.is_string() || !check_broker(host.get<std::string>())) return {};
    list.hosts.push_back(host.get<std::string>());
  }
  for (const auto& one : *folders) {
    auto folder = one.is_object() ? folder_in(one) : std::nullopt;
    if (!folder) return {};
    list.folders.push_back(std::move(*folder));
  }
  return list;
}

std::string address_text(const std::string& host, std::uint16_t port) {
  return host.find(':') == host.npos ? fmt::format("{}:{}", host, port) : fmt::format("[{}]:{}", host, port);
}

}  // namespace

Result<void> check_broker(const std::string& text) {
  const auto address = base::parse_host_port(text, kDefaultPort);
  if (address && !address->host.empty() && base::host_fault(address->host).empty()) return {};
  return fail(ErrorCode::kInvalid, fmt::format("`{}` is no broker: expected HOST or HOST:PORT, such as "
                                               "broker.example.org or 192.168.1.5:8883",
                                               base::one_line(text.substr(0, 80))));
}

Result<BrokerList> BrokerList::read(const SiteFolder& folder) {
  const auto text = folder.files().read(kBrokersFile, kMaxBrokerList);
  if (!text) return fail(text.error());
  const auto json = base::is_nested_deeper(*text, kBrokerLevels) ? Json() : model::parse_json(*text);
  auto list = list_in(json);
  if (!list)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: expected what `rubicon trust broker` wrote", folder.files().path(kBrokersFile)));
  return std::move(*list);
}

Result<void> BrokerList::write(const SiteFolder& folder) const {
  Json json{{"hosts", hosts}, {"folders", Json::array()}};
  for (const auto& one : folders) json["folders"].push_back(json_of(one));
  return folder.files().write(kBrokersFile, model::dump(json) + "\n", kBrokersMode);
}

BrokerFolder* BrokerList::find(const std::string& folder) {
  const auto found =
      std::find_if(folders.begin(), folders.end(), [&](const BrokerFolder& one) { return one.setup.folder == folder; });
  return found == folders.end() ? nullptr : &*found;
}

bool BrokerList::take_passwords() const {
  return std::any_of(folders.begin(), folders.end(), [](const BrokerFolder& one) { return one.setup.takes_passwords; });
}

std::vector<std::string> BrokerList::addresses(bool with_password) const {
  const auto own = std::find_if(folders.begin(), folders.end(), [with_password](const BrokerFolder& one) {
    return !with_password || one.setup.takes_passwords;
  });
  const auto usual = own == folders.end() ? kDefaultPort : own->setup.port;
  std::vector<std::string> all;
  for (const auto& host : hosts) {
    auto address = base::parse_host_port(host, usual);
    if (!address) continue;
    if (with_password && own != folders.end() && address->port == own->setup.port) ++address->port;
    all.push_back(address_text(address->host, address->port));
  }
  return all;
}

std::vector<std::string> BrokerList::names() const {
  std::vector<std::string> all;
  for (const auto& host : hosts) {
    const auto address = base::parse_host_port(host, kDefaultPort);
    if (address && std::find(all.begin(), all.end(), address->host) == all.end()) all.push_back(address->host);
  }
  return all;
}

}  // namespace rubicon::trust::site
