#include "apps/rubicon/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <set>

#include "base/config_reader.h"
#include "base/text.h"
#include "client/ecology_options.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "transport/local_transports.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::cli {

namespace {

constexpr const char* kGroup = "Options of all commands";

using OptionOfEngine = std::pair<const char*, client::Engine>;
constexpr OptionOfEngine kOptionsOfEngines[] = {{"--domain", client::Engine::kDds},
                                                {"--peers", client::Engine::kDds},
                                                {"--tcp", client::Engine::kDds},
                                                {"--tag", client::Engine::kDds},
                                                {"--broker", client::Engine::kMqtt},
                                                {"--broker-user", client::Engine::kMqtt},
                                                {"--broker-password-file", client::Engine::kMqtt},
                                                {"--peis-network", client::Engine::kPeis},
                                                {"--peis-listen", client::Engine::kPeis},
                                                {"--peis-connect", client::Engine::kPeis},
                                                {"--peis-multicast", client::Engine::kPeis},
                                                {"--folder", client::Engine::kHost},
                                                {"--space", client::Engine::kHost}};
/// In the order of decision 022.
constexpr std::pair<const char*, client::Engine> kEngines[] = {{"host", client::Engine::kHost},
                                                               {"dds", client::Engine::kDds},
                                                               {"mqtt", client::Engine::kMqtt},
                                                               {"peis", client::Engine::kPeis}};

/// Options that say where components are.
constexpr std::array kPlaces{"--engine", "--folder", "--domain",       "--interfaces",
                             "--peers",  "--broker", "--peis-network", "--peis-connect"};

const char* to_string(client::Engine engine) {
  return std::find_if(std::begin(kEngines), std::end(kEngines), [&](const auto& one) { return one.second == engine; })
      ->first;
}

/// The error in the text of a PEIS component to connect to; empty if it is correct.
std::string check_target(const std::string& text) {
  const auto target = tuples::peis::connect_target(text);
  return target ? std::string() : fmt::format("is '{}', {}", text, target.error().text);
}

Result<client::Broker> broker_of(const config::MqttSpaceSetup& setup) {
  transport::LocalTransports files;
  auto space = setup.options(files);
  if (!space) return fail(std::move(space.error()));
  const auto& line = space->brokers.front().line;
  const auto& user = space->brokers.front().user;
  client::Broker broker;
  broker.host = line.host;
  broker.port = line.port;
  broker.space = space->space;
  if (user != tuples::mqtt::kAnonymous) broker.user = user;
  for (const auto& [host, port] : setup.spare) {
    const bool is_v6 = host.find(':') != host.npos;
    broker.spare.push_back(is_v6 ? fmt::format("[{}]:{}", host, port) : fmt::format("{}:{}", host, port));
  }
  broker.password = line.password;
  broker.tls = line.tls.has_value();
  broker.lease = space->lease;
  broker.trust = space->trust_broker;
  broker.all = space->watch_all;
  if (!line.tls) return broker;
  broker.ca_file = line.tls->ca_file;
  broker.certificate_file = line.tls->certificate_file;
  broker.key_file = line.tls->key_file;
  broker.server_name = line.tls->server_name;
  return broker;
}

/// Takes engine and prefix from the configuration of an island and ignores the rest, which may need networks that this
/// program does not have.
Result<void> read_config(const std::string& path, Settings& settings) {
  const auto root = config::load_config(path, {});
  if (!root) return fail(root.error());
  ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto engine = config::read_engine(reader, std::filesystem::path(path).parent_path().string());
  settings.prefix = reader.map("island").text("prefix", settings.prefix);
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  if (engine.alone())
    return fail(ErrorCode::kInvalid,
                fmt::format("{}tuples.engine is memory: such an island is alone in its process", engine.place));
  auto& options = settings.options;
  options.engines.clear();
  if (engine.host) options.engines.push_back(client::Engine::kHost);
  if (engine.dds) options.engines.push_back(client::Engine::kDds);
  if (engine.mqtt) options.engines.push_back(client::Engine::kMqtt);
  if (engine.peis) options.engines.push_back(client::Engine::kPeis);
  if (engine.mqtt) {
    auto broker = broker_of(engine.mqtt_space);
    if (!broker) return fail(std::move(broker.error()));
    options.broker = std::move(*broker);
  }
  options.folder = std::getenv("RUBICON_FOLDER") ? "" : engine.folder;
  options.space = engine.space;
  const auto& peis = engine.peis_options;
  options.peis = {peis.network, peis.listen, peis.connect, peis.multicast};
  if (engine.dds) {
    options.domain = engine.options.domain;
    options.tag = engine.options.tag;
  }
  options.lease = engine.options.lease;
  if (engine.dds || engine.peis) options.interfaces = engine.options.interfaces;
  options.peers = engine.options.peers;
  options.tcp = engine.options.transport == tuples::dds::DdsTransport::kTcp;
  return {};
}

}  // namespace

std::string check_duration(const std::string& text) {
  const auto span = base::parse_duration(text);
  if (span && *span >= Duration(0)) return {};
  return fmt::format("is '{}', expected a duration such as 250ms, 5s, 2min, 1h", text);
}

Duration parse_duration_or(const std::string& text, Duration otherwise) {
  return text.empty() ? otherwise : base::parse_duration(text).value_or(otherwise);
}

bool uses(const client::Options& options, client::Engine engine) {
  return client::has_engine(options, engine);
}

namespace {

/// `broker.lan:8883/city`, as --broker takes it.
std::string broker_text(const client::Broker& broker) {
  return fmt::format("{}{}{}", broker.host, broker.port == 0 ? "" : fmt::format(":{}", broker.port),
                     broker.space == "default" ? "" : "/" + broker.space);
}

/// kInvalid: HOST[:PORT][/SPACE] was expected.
Result<void> read_broker(const std::string& text, client::Broker& broker) {
  const auto slash = text.find('/');
  const auto address = base::parse_host_port(text.substr(0, slash), 1);
  if (!address || address->host.empty() || (slash != text.npos && slash + 1 == text.size()))
    return fail(ErrorCode::kInvalid,
                fmt::format("--broker: is '{}', expected HOST[:PORT][/SPACE], such as broker.lan/city", text));
  broker.host = address->host;
  broker.port = address->port == 1 ? 0 : address->port;
  if (slash != text.npos) broker.space = text.substr(slash + 1);
  return {};
}

}  // namespace

std::string place_text(const client::Options& options) {
  const bool dds = uses(options, client::Engine::kDds), peis = uses(options, client::Engine::kPeis);
  std::vector<std::string> parts;
  if (const auto engines = client::engine_options(options); engines && engines->host) {
    const auto& space = engines->host->space;
    parts.push_back(fmt::format("folder {}{}", engines->host->place.path,
                                space == tuples::host::kDefaultSpace ? "" : ", space " + space));
  }
  if (dds) parts.push_back(fmt::format("domain {}", options.domain));
  if (uses(options, client::Engine::kMqtt)) parts.push_back(fmt::format("broker {}", broker_text(options.broker)));
  if (peis) parts.push_back("PEIS network " + options.peis.network);
  auto text = fmt::format("{}", fmt::join(parts, " and "));
  if (dds || peis)
    text += fmt::format(" on {}{}",
                        options.interfaces.empty() ? "lo" : fmt::format("{}", fmt::join(options.interfaces, ", ")),
                        dds && options.tcp ? " over TCP" : "");
  if (dds && !options.tag.empty()) text += fmt::format(", tag {}", options.tag);
  if (dds && !options.peers.empty()) text += fmt::format(", peers {}", fmt::join(options.peers, " "));
  if (peis && !options.peis.connect.empty()) text += fmt::format(", connect {}", fmt::join(options.peis.connect, " "));
  return text;
}

std::string elsewhere_text(const client::Options& options) {
  const auto engines = client::engine_options(options);
  if (!engines || !engines->host) return {};
  const auto around = tuples::host::Surroundings::of_process();
  std::string text;
  const auto others = tuples::host::other_places(engines->host->place.path, around);
  if (!others.empty())
    text = fmt::format("; components are in {} (for the user of it: --folder {})", fmt::join(others, ", "),
                       others.front());
  if (tuples::host::is_shut_out(around))
    text += fmt::format("; {} is open to members of group rubicon: sudo usermod -aG rubicon $USER, then log in again",
                        around.installed);
  return text;
}

std::string place_options(const client::Options& options) {
  const bool dds = uses(options, client::Engine::kDds), peis = uses(options, client::Engine::kPeis);
  std::vector<std::string> all, engines;
  for (const auto engine : options.engines) engines.emplace_back(to_string(engine));
  const bool usual = !peis && uses(options, client::Engine::kHost) && (!dds || !options.interfaces.empty());
  if (!engines.empty() && !usual) all.push_back(fmt::format("--engine {}", fmt::join(engines, ",")));
  if (!options.folder.empty()) all.push_back("--folder " + options.folder);
  if (!options.space.empty()) all.push_back("--space " + options.space);
  if (!options.broker.host.empty()) all.push_back("--broker " + broker_text(options.broker));
  if (peis) all.push_back("--peis-network " + options.peis.network);
  if (peis && !options.peis.connect.empty())
    all.push_back(fmt::format("--peis-connect {}", fmt::join(options.peis.connect, ",")));
  if (peis && !options.peis.multicast) all.emplace_back("--peis-multicast no");
  const bool has_domain =
      dds || (uses(options, client::Engine::kHost) && (options.domain != 0 || !options.tag.empty()));
  if (has_domain) all.push_back(fmt::format("--domain {}", options.domain));
  if (!options.interfaces.empty()) all.push_back(fmt::format("--interfaces {}", fmt::join(options.interfaces, ",")));
  if (dds && options.tcp) all.emplace_back("--tcp");
  if (has_domain && !options.tag.empty()) all.push_back("--tag " + options.tag);
  if (dds && !options.peers.empty()) all.push_back(fmt::format("--peers {}", fmt::join(options.peers, ",")));
  return fmt::format("{}", fmt::join(all, " "));
}

std::string ecology_file() {
  std::vector<std::filesystem::path> files;
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != 0)
    files.push_back(std::filesystem::path(home) / ".config/rubicon/ecology.yaml");
  files.emplace_back("/etc/rubicon/ecology.yaml");
  std::error_code none;
  for (const auto& file : files) {
    if (std::filesystem::exists(file, none)) return file.string();
  }
  return {};
}

void SettingsOptions::add_to(CLI::App& app) {
  app_ = &app;
  const auto* const group = kGroup;
  add_engines_to(app);
  app.add_option("--folder", folder_, "where the programs of this host meet; default /run/rubicon, or the user's own")
      ->type_name("FOLDER")
      ->group(group);
  app.add_option("--space", space_, "see only components of this space of the folder; default default")->group(group);
  app.add_option("--domain", domain_, "DDS domain of the islands, 0..230")
      ->type_name("N")
      ->check(CLI::Range(0U, tuples::dds::kMaxDomain).description(""))
      ->group(group);
  app.add_option("--interfaces", interfaces_, "network interfaces for DDS and PEIS, with commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  app.add_option("--peers", peers_, "hosts that multicast does not reach, with commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  app.add_flag("--tcp", tcp_, "reach the peers (HOST:PORT) over TCP")->group(group);
  app.add_option("--tag", tag_, "see only components with this tag")->group(group);
  app.add_option("--trust", trust_)->group("");  // of earlier releases
  app.add_option("--lease", lease_, "silence after which a component counts as lost")
      ->type_name("SPAN")
      ->check(check_duration)
      ->group(group);
  app.add_option("--patience", patience_, "how long to wait for answers; default 3s")
      ->type_name("SPAN")
      ->check(check_duration)
      ->group(group);
  app.add_option("--prefix", prefix_, "first part of the islands' keys; default proxy")->group(group);
  app.add_option("--config", config_, "take these options from the configuration file of an island")->group(group);
  app.add_flag("--json", json_, "JSON lines for programs instead of tables for people")->group(group);
  for (const auto* name : {"engine",
                           "folder",
                           "space",
                           "domain",
                           "interfaces",
                           "peers",
                           "tcp",
                           "tag",
                           "trust",
                           "lease",
                           "patience",
                           "prefix",
                           "config",
                           "json",
                           "broker",
                           "broker-user",
                           "broker-password-file",
                           "peis-network",
                           "peis-listen",
                           "peis-connect",
                           "peis-multicast"}) {
    std::string variable = "RUBICON_";
    for (const char c : std::string_view(name)) variable += c == '-' ? '_' : static_cast<char>(c - 'a' + 'A');
    app.get_option(std::string("--") + name)->envname(variable);
  }
}

void SettingsOptions::add_engines_to(CLI::App& app) {
  app.add_option(
         "--engine", engines_,
         "with commas: host (this host), dds, mqtt (a broker), peis (the network of the PEIS kernels); default host, "
         "with interfaces host,dds, with a broker host,mqtt")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"host", "dds", "mqtt", "peis"}).description(""))
      ->group(kGroup);
  app.add_option("--broker", broker_, "MQTT broker where the islands of all sites meet")
      ->type_name("HOST[:PORT][/SPACE]")
      ->group(kGroup);
  app.add_option("--broker-user", broker_user_, "user name of this program at the broker")
      ->type_name("NAME")
      ->group(kGroup);
  app.add_option("--broker-password-file", broker_password_, "file with the password of that user")
      ->type_name("FILE")
      ->group(kGroup);
  app.add_option("--peis-network", peis_network_, "name of the PEIS network; default default")->group(kGroup);
  app.add_option("--peis-listen", peis_listen_, "TCP port for PEIS, or the next free one; default 8000")
      ->type_name("PORT")
      ->check(CLI::Range(0U, 0xffffU).description(""))
      ->group(kGroup);
  app.add_option("--peis-connect", peis_connect_, "PEIS components that multicast does not reach: tcp://HOST:PORT,...")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(check_target)
      ->group(kGroup);
  app.add_option("--peis-multicast", peis_multicast_, "whether to search for PEIS components by multicast; default yes")
      ->check(CLI::IsMember({"yes", "no"}).description(""))
      ->group(kGroup);
}

/// What they say about the broker.
Result<void> SettingsOptions::read_broker_options(client::Broker& broker) const {
  if (!broker_.empty()) {
    if (auto good = read_broker(broker_, broker); !good) return good;
  }
  if (!broker_user_.empty()) broker.user = broker_user_;
  if (broker_password_.empty()) return {};
  transport::MqttBrokerOptions file;
  file.password_file = broker_password_;
  transport::LocalTransports files;
  auto line = file.with_password(files);
  if (!line) return fail(line.error().code, "--broker-password-file: " + line.error().text);
  broker.password = line->password;
  return {};
}

/// What the command line or the environment say about the engines.
void SettingsOptions::read_engines(client::Options& options) const {
  const auto given = [this](const char* name) { return app_->get_option(name)->count() > 0; };
  // A file of an island on its host alone may be asked for with options of DDS.
  const bool asks_for_dds = given("--interfaces") || given("--peers") || given("--tcp");
  if (given("--engine")) {
    options.engines.clear();
    for (const auto& [name, engine] : kEngines) {
      if (std::count(engines_.begin(), engines_.end(), name) > 0) options.engines.push_back(engine);
    }
  } else if (asks_for_dds && !uses(options, client::Engine::kDds) && !uses(options, client::Engine::kPeis)) {
    options.engines = {client::Engine::kHost, client::Engine::kDds};
  }
  if (!given("--engine") && given("--broker") && !uses(options, client::Engine::kMqtt))
    options.engines.push_back(client::Engine::kMqtt);
  if (given("--folder")) options.folder = folder_;
  if (given("--space")) options.space = space_;
  if (given("--peis-network")) options.peis.network = peis_network_;
  if (given("--peis-listen")) options.peis.listen = static_cast<std::uint16_t>(peis_listen_);
  if (given("--peis-connect")) options.peis.connect = peis_connect_;
  if (given("--peis-multicast")) options.peis.multicast = peis_multicast_ == "yes";
}

/// On the command line; the environment and the file may serve several engines.
bool SettingsOptions::is_typed(const char* name) const {
  const auto& typed = app_->parse_order();
  return std::find(typed.begin(), typed.end(), app_->get_option(name)) != typed.end();
}

/// kInvalid: an option was typed that changes nothing with these engines.
Result<void> SettingsOptions::check_engines(const client::Options& options) const {
  const std::set<std::string> named(engines_.begin(), engines_.end());
  if (is_typed("--engine") && named.size() < engines_.size())
    return fail(ErrorCode::kInvalid, "--engine: names an engine twice, expected some of host,dds,mqtt,peis");
  for (const auto& [name, engine] : kOptionsOfEngines) {
    const std::string_view option = name;
    // A domain and a tag become a space.
    const bool is_old_space = (option == "--domain" || option == "--tag") && options.engines.empty();
    if (!is_typed(name) || uses(options, engine) || is_old_space) continue;
    return fail(ErrorCode::kInvalid, fmt::format("{}: only engine {} has this option, expected --engine with {}", name,
                                                 to_string(engine), to_string(engine)));
  }
  return {};
}

Result<Settings> SettingsOptions::read() const {
  Settings settings;
  const auto given = [this](const char* name) { return app_->get_option(name)->count() > 0; };
  const bool says_where = std::any_of(kPlaces.begin(), kPlaces.end(), given);
  if (const auto file = !config_.empty() ? config_ : says_where ? std::string() : ecology_file(); !file.empty()) {
    if (auto good = read_config(file, settings); !good) return fail(good.error());
  }
  auto& options = settings.options;
  if (auto good = read_broker_options(options.broker); !good) return fail(good.error());
  read_engines(options);
  if (auto good = check_engines(options); !good) return fail(good.error());
  if (given("--trust") && trust_ != "no" && (is_typed("--trust") || uses(options, client::Engine::kDds)))
    return fail(
        ErrorCode::kInvalid,
        fmt::format(
            "{}: this release has no certificates for DDS, which trusts all machines of its "
            "network; hosts that do not trust each other meet at a broker with a realm (docs/trust.md, docs/sites.md)",
            is_typed("--trust") ? "--trust" : "RUBICON_TRUST"));
  if (given("--domain")) options.domain = domain_;
  if (given("--interfaces")) options.interfaces = interfaces_;
  if (given("--peers")) options.peers = peers_;
  if (given("--tcp")) options.tcp = tcp_;
  if (given("--tag")) options.tag = tag_;
  if (given("--prefix")) settings.prefix = prefix_;
  options.lease = parse_duration_or(lease_, options.lease);
  settings.patience = parse_duration_or(patience_, settings.patience);
  settings.json = json_;
  settings.config = config_;
  return settings;
}

void AsOptions::add_to(CLI::App& app) {
  app.add_option("--name", name_, "name of this component");
  app.add_option("--id", id_, "id of this component, above 65535; random by default")
      ->type_name("ID")
      ->check(CLI::Range(model::kMaxIslandId + 4U, tuples::peis::kMaxId).description(""));
}

Settings AsOptions::applied(Settings settings) const {
  if (!name_.empty()) settings.options.name = name_;
  if (id_ != 0) settings.options.id = OwnerId(id_);
  return settings;
}

std::string check_pattern(const std::string& text) {
  const auto pattern = Pattern::parse(text);
  return pattern ? std::string() : pattern.error().text;
}

std::vector<Pattern> patterns_in(const std::vector<std::string>& texts) {
  std::vector<Pattern> patterns;
  for (const auto& text : texts) patterns.push_back(*Pattern::parse(text));
  return patterns;
}

}  // namespace rubicon::cli
