#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

/// What all commands have in common: where to meet the others, and how to show what is found.
struct Settings {
  client::Options options;
  std::string prefix = "proxy";  ///< first part of the islands' keys
  Duration patience = std::chrono::seconds(3);
  bool json = false;
};

/// `domain 3 on eth0, peers 10.0.0.2`.
std::string place_text(const client::Options& options);

/// The options as they stand on the command line; each is also taken from the environment (RUBICON_DOMAIN, ...).
class SettingsOptions {
 public:
  void add_to(CLI::App& app);
  /// The file first, then the environment, then the command line. Errors name where the wrong value stands.
  Result<Settings> read() const;

 private:
  std::uint32_t domain_ = 0;
  std::vector<std::string> interfaces_, peers_;
  std::string tag_, lease_, patience_, prefix_, config_;
  bool json_ = false, tcp_ = false;
  CLI::App* app_ = nullptr;
};

/// As whom a command takes part, as options: --name, --id.
class AsOptions {
 public:
  void add_to(CLI::App& app);
  Settings applied(Settings settings) const;

 private:
  std::string name_;
  std::uint32_t id_ = 0;
};

/// For options that are a SPAN: `250ms`, `5s`.
std::string wrong_with_span(const std::string& text);
/// Of a text that wrong_with_span() found good; empty = `otherwise`.
Duration span_of(const std::string& text, Duration otherwise = Duration(0));

}  // namespace rubicon::cli
