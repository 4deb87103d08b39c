#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>

#include "apps/rubicon/trust/site/commands.h"
#include "base/own_file.h"
#include "base/text.h"
#include "model/json_members.h"
#include "trust/site/site_folder.h"

namespace rubicon::cli::trust::site {

namespace {

namespace fs = std::filesystem;
namespace sites = rubicon::trust::site;

constexpr const char* kBrokerFolder = "/etc/rubicon/broker";
constexpr const char* kBrokerState = "/var/lib/rubicon-broker";
constexpr const char* kBrokerUnit = "rubicon-broker@";
constexpr std::uint16_t kFirstPort = 8883, kLastPort = 8983;

struct MosquittoOptions {
  std::vector<std::string> hosts;
  std::string name = "main", folder, realm;
  std::uint16_t port = 0;
  bool passwords = false, no_passwords = false;
};

/// Of a unit: a folder of its own below /etc/rubicon/broker.
Result<void> check_unit_name(const std::string& name) {
  const bool good =
      !name.empty() && name.size() <= 64 && name.front() != '-' && std::all_of(name.begin(), name.end(), [](char c) {
        return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9') || c == '-' || c == '_';
      });
  if (good) return {};
  return fail(ErrorCode::kInvalid, fmt::format("--name {}: expected letters, digits, `-` and `_`", name));
}

/// Whether the port is free on all addresses.
bool is_port_free(std::uint16_t port) {
  const auto socket = base::OwnFile::of_descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  constexpr int kYes = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &kYes, sizeof kYes);
  return ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

/// 8883, or the next one; with passwords the next one of two.
Result<std::uint16_t> choose_port(bool passwords) {
  for (auto port = kFirstPort; port < kLastPort; ++port) {
    if (is_port_free(port) && (!passwords || is_port_free(static_cast<std::uint16_t>(port + 1)))) return port;
  }
  return fail(ErrorCode::kBusy, fmt::format("no free port from {} to {}, expected --port N", kFirstPort, kLastPort));
}

/// The user of the unit, or the one that a mosquitto takes which root starts by hand.
std::string broker_user() {
  if (::geteuid() != 0) return {};
  for (const auto* name : {"rubicon-broker", "mosquitto"}) {
    if (sites::service_user(name)) return name;
  }
  return {};
}

/// That of --broker HOST:PORT, for a broker that is new.
std::uint16_t port_of_hosts(const std::vector<std::string>& hosts) {
  const auto address = hosts.empty() ? std::nullopt : base::parse_host_port(hosts.front());
  return address ? address->port : std::uint16_t{0};
}

Result<sites::BrokerFolder> wanted_broker(const MosquittoOptions& options, const sites::SiteContents& there) {
  if (auto named = check_unit_name(options.name); !named) return fail(named.error());
  const bool is_own = !options.folder.empty();
  auto folder = is_own ? fs::absolute(options.folder).lexically_normal() : fs::path(kBrokerFolder) / options.name;
  if (folder.filename().empty()) folder = folder.parent_path();
  const auto known = std::find_if(there.brokers.begin(), there.brokers.end(),
                                  [&](const auto& one) { return one.setup.folder == folder.string(); });
  sites::BrokerFolder broker;
  if (known != there.brokers.end()) {
    broker = *known;
  } else {
    broker.setup.folder = folder.string();
    broker.setup.state = is_own ? (folder / "state").string() : (fs::path(kBrokerState) / options.name).string();
    broker.setup.port = port_of_hosts(options.hosts.empty() ? there.hosts : options.hosts);
    broker.unit = is_own ? std::string() : kBrokerUnit + options.name;
  }
  broker.setup.user = broker_user();
  if (options.passwords || options.no_passwords) broker.setup.takes_passwords = options.passwords;
  if (options.port != 0) broker.setup.port = options.port;
  if (broker.setup.port != 0) return broker;
  const auto port = choose_port(broker.setup.takes_passwords);
  if (!port) return fail(port.error());
  broker.setup.port = *port;
  return broker;
}

void put_set_up(Output& out, const sites::BrokerFolder& broker) {
  const auto& setup = broker.setup;
  out.line(fmt::format("broker       {}, port {}{}", setup.folder, setup.port,
                       setup.takes_passwords ? fmt::format(", for members with a password {}", setup.port + 1) : ""));
  if (broker.unit.empty()) {
    out.line(fmt::format("start        mosquitto -c {}/{}", setup.folder, sites::kMosquittoFile));
    return;
  }
  out.line("start        systemctl enable --now " + broker.unit);
  out.line("if it runs   systemctl reload " + broker.unit + "; after another port or --passwords: systemctl restart");
}

int set_up_broker(const Settings& settings, const MosquittoOptions& options) {
  const auto folder = realm_folder(options.realm);
  if (!folder) return failed(folder.error());
  const auto there = sites::contents_of(*folder, now());
  if (!there) return failed_at(*folder, there.error());
  const auto wanted = wanted_broker(options, *there);
  if (!wanted) return failed(wanted.error());
  const auto made = sites::set_up_mosquitto(*folder, *wanted, options.hosts, now());
  if (!made) return failed_at(*folder, made.error());
  Output out(1);
  if (settings.json) {
    out.line(model::dump({{"folder", made->setup.folder},
                          {"port", made->setup.port},
                          {"passwords", made->setup.takes_passwords},
                          {"unit", made->unit}}));
  } else {
    put_set_up(out, *made);
  }
  return ended(out, kGood);
}

}  // namespace

void add_broker(Cli& cli, CLI::App* parent) {
  auto* broker = parent->add_subcommand("broker", "Write the files of a broker of the realm: mosquitto");
  broker->require_subcommand(1);
  broker->fallthrough();
  broker->get_formatter()->label("SUBCOMMAND", "BROKER");
  broker->footer("Example:\n  sudo rubicon trust broker mosquitto --broker broker.example.org\n");
  const auto [app, options] = cli.command_with<MosquittoOptions>(
      {"mosquitto", "Write configuration, certificate and access list of a mosquitto, for the unit rubicon-broker@",
       "  sudo rubicon trust broker mosquitto --broker broker.example.org\n"
       "  sudo rubicon trust broker mosquitto --passwords\n"
       "Run it again for another name, or before the certificate of the broker ends (10 years).\n",
       broker},
      set_up_broker);
  app->add_option("--broker", options->hosts,
                  "how members reach it, HOST or HOST:PORT (may be repeated); default what is known")
      ->allow_extra_args(false);
  app->add_option("--port", options->port, "TCP port; default the one it has, else 8883 or the next free one")
      ->type_name("PORT")
      ->check(CLI::Range(1U, 65534U).description(""));
  auto* passwords = app->add_flag("--passwords", options->passwords, "the next port is for members with a password");
  app->add_flag("--no-passwords", options->no_passwords, "members need a certificate (default)")->excludes(passwords);
  auto* name = app->add_option("--name", options->name, "name of the unit: rubicon-broker@NAME");
  name->capture_default_str();
  app->add_option("--out", options->folder, "folder to write instead of /etc/rubicon/broker/NAME; no unit uses it")
      ->type_name("FOLDER")
      ->excludes(name);
  add_realm_option(app, options->realm);
}

}  // namespace rubicon::cli::trust::site
