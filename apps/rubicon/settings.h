#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

/// Settings of all commands: where to look for islands, and how to print results.
struct Settings {
  client::Options options;
  std::string prefix = "proxy";  ///< first part of the islands' keys
  Duration patience = std::chrono::seconds(3);
  bool json = false;
  std::string config;  ///< the file of --config; empty = none
};

bool uses(const client::Options& options, client::Engine engine);
/// `folder /run/rubicon`, `domain 3 on eth0, peers 10.0.0.2`, `PEIS network default on lo`.
std::string place_text(const client::Options& options);
/// The same as options of the command line: `--domain 3 --interfaces eth0 --peers 10.0.0.2`.
std::string place_options(const client::Options& options);

/// Where else on this host components are, or what keeps this user out: `; components are in ...`; empty = nothing.
std::string elsewhere_text(const client::Options& options);

/// The options of the command line; each has an environment variable (RUBICON_DOMAIN, ...).
class SettingsOptions {
 public:
  void add_to(CLI::App& app);
  /// The file first, then the environment, then the command line. Errors name the source of the wrong value. The file
  /// is the one of --config; if no option says where to look, it is ecology_file().
  Result<Settings> read() const;

 private:
  void add_engines_to(CLI::App& app);
  void read_engines(client::Options& options) const;
  Result<void> read_broker_options(client::Broker& broker) const;
  bool is_typed(const char* name) const;
  Result<void> check_engines(const client::Options& options) const;

  std::uint32_t domain_ = 0;
  std::uint32_t peis_listen_ = 0;
  std::vector<std::string> engines_, interfaces_, peers_, peis_connect_;
  std::string broker_, broker_user_, broker_password_;
  std::string peis_network_, peis_multicast_;
  std::string folder_, space_, tag_, trust_, lease_, patience_, prefix_, config_;
  bool json_ = false, tcp_ = false;
  CLI::App* app_ = nullptr;
};

/// The ecology that the tools of this user, or of all users of this host, join by default:
/// ~/.config/rubicon/ecology.yaml, /etc/rubicon/ecology.yaml. Empty: there is none.
std::string ecology_file();

/// Options for the name and id of this component: --name, --id.
class AsOptions {
 public:
  void add_to(CLI::App& app);
  Settings applied(Settings settings) const;

 private:
  std::string name_;
  std::uint32_t id_ = 0;
};

/// The error in the text of a duration (`250ms`, `5s`); empty if it is correct.
std::string check_duration(const std::string& text);
/// The duration in a text that check_duration() accepted; `otherwise` for an empty text.
Duration parse_duration_or(const std::string& text, Duration otherwise = Duration(0));
/// The error in the text of a pattern; empty if it is correct.
std::string check_pattern(const std::string& text);
/// The patterns in texts that check_pattern() accepted.
std::vector<Pattern> patterns_in(const std::vector<std::string>& texts);

}  // namespace rubicon::cli
