#include "trust/site/brokers.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::trust::site {

namespace {

/// A value of a tuple has at most 1 MiB; its frame has names and numbers besides.
constexpr std::size_t kMessageLimit = 2UL << 20U;

std::string certificates_of(const MosquittoSetup& setup) {
  return fmt::format("certfile {0}/{1}\nkeyfile {0}/{2}\n", setup.folder, kBrokerCertificateFile, kBrokerKeyFile);
}

}  // namespace

std::string mosquitto_conf(const MosquittoSetup& setup) {
  auto text =
      fmt::format("# Written by `rubicon trust broker mosquitto`, which writes it again. Own lines: {}/*.conf\n",
                  kBrokerMoreFolder);
  if (!setup.user.empty()) text += fmt::format("user {}\n", setup.user);
  text +=
      "per_listener_settings false\n"
      "allow_anonymous false\n";
  text += fmt::format("acl_file {}/{}\n", setup.folder, kAclFile);
  if (setup.takes_passwords) text += fmt::format("password_file {}/{}\n", setup.folder, kBrokerPasswordsFile);
  // Clients write their presence again after a restart of the broker, so saving at intervals is enough. Saving at each
  // change would write the database for each of a thousand members that come back.
  text += fmt::format(
      "persistence true\n"
      "persistence_location {}/\n"
      "autosave_interval 30\n"
      "autosave_on_changes false\n"
      "max_queued_messages 100000\n"
      "message_size_limit {}\n"
      "set_tcp_nodelay true\n"
      "log_dest stderr\n"
      "log_type error\nlog_type warning\nlog_type notice\n",
      setup.state, kMessageLimit);
  text += fmt::format(
      "\n# Members with a certificate.\n"
      "listener {}\n"
      "cafile {}/{}\n"
      "crlfile {}/{}\n"
      "{}"
      "require_certificate true\n"
      "use_identity_as_username true\n",
      setup.port, setup.folder, kBrokerAuthorityFile, setup.folder, kBrokerRevocationFile, certificates_of(setup));
  if (setup.takes_passwords)
    text += fmt::format("\n# Members with a password.\nlistener {}\n{}", setup.port + 1, certificates_of(setup));
  return text + fmt::format("\ninclude_dir {}/{}\n", setup.folder, kBrokerMoreFolder);
}

std::string mosquitto_acl(const std::set<std::string, std::less<>>& revoked) {
  std::string text =
      "# Written by `rubicon trust`. %u is the user: the name in its certificate, or that with its password.\n"
      "pattern read rubicon-space/1/+/p/#\n"
      "pattern write rubicon-space/1/+/p/+/%u/#\n"
      "pattern read rubicon-space/1/+/to/%u/#\n"
      "pattern write rubicon-space/1/+/to/+/+/%u/+\n";
  for (const auto& user : revoked) text += fmt::format("\nuser {}\ntopic deny #\n", user);
  return text;
}

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
  return fail(ErrorCode::kInvalid, fmt::format("`{}` is not a broker: expected HOST or HOST:PORT, such as "
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
