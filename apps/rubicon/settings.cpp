#include "apps/rubicon/settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/config_reader.h"
#include "config/config_file.h"
#include "config/engine_config.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::cli {

namespace {

/// Takes engine and prefix from the configuration of an island and ignores the rest, which may need networks that this
/// program does not have.
Result<void> read_config(const std::string& path, Settings& settings) {
  const auto root = config::load_config(path, {});
  if (!root) return fail(root.error());
  ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  auto engine = config::read_engine(reader);
  settings.prefix = reader.map("island").text("prefix", settings.prefix);
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  if (!engine.dds && engine.peis)
    return fail(ErrorCode::kUnsupported,
                fmt::format("{}tuples.engine is peis alone: this program needs dds too", engine.place));
  if (!engine.dds)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}tuples.engine is memory: such an island is alone in its process", engine.place));
  auto& options = settings.options;
  options.domain = engine.options.domain;
  options.tag = engine.options.tag;
  options.lease = engine.options.lease;
  options.interfaces = engine.options.interfaces;
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

std::string place_text(const client::Options& options) {
  auto text = fmt::format("domain {} on {}{}", options.domain, fmt::join(options.interfaces, ", "),
                          options.tcp ? " over TCP" : "");
  if (!options.tag.empty()) text += fmt::format(", tag {}", options.tag);
  if (!options.peers.empty()) text += fmt::format(", peers {}", fmt::join(options.peers, " "));
  return text;
}

std::string place_options(const client::Options& options) {
  auto text = fmt::format("--domain {} --interfaces {}", options.domain, fmt::join(options.interfaces, ","));
  if (options.tcp) text += " --tcp";
  if (!options.tag.empty()) text += " --tag " + options.tag;
  if (!options.peers.empty()) text += fmt::format(" --peers {}", fmt::join(options.peers, ","));
  return text;
}

void SettingsOptions::add_to(CLI::App& app) {
  app_ = &app;
  const auto group = "Options of all commands";
  app.add_option("--domain", domain_, "DDS domain of the islands, 0..230")
      ->type_name("N")
      ->check(CLI::Range(0U, tuples::dds::kMaxDomain).description(""))
      ->group(group);
  app.add_option("--interfaces", interfaces_, "network interfaces, with commas; lo = this host")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  app.add_option("--peers", peers_, "hosts that multicast does not reach, with commas")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->group(group);
  app.add_flag("--tcp", tcp_, "reach the peers (HOST:PORT) over TCP")->group(group);
  app.add_option("--tag", tag_, "see only components with this tag")->group(group);
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
  for (const auto* name :
       {"domain", "interfaces", "peers", "tcp", "tag", "lease", "patience", "prefix", "config", "json"}) {
    std::string variable = "RUBICON_";
    for (const char c : std::string_view(name)) variable += static_cast<char>(c - 'a' + 'A');
    app.get_option(std::string("--") + name)->envname(variable);
  }
}

Result<Settings> SettingsOptions::read() const {
  Settings settings;
  const auto given = [this](const char* name) { return app_->get_option(name)->count() > 0; };
  if (!config_.empty()) {
    if (auto good = read_config(config_, settings); !good) return fail(good.error());
  }
  auto& options = settings.options;
  if (given("--domain")) options.domain = domain_;
  if (given("--interfaces")) options.interfaces = interfaces_;
  if (given("--peers")) options.peers = peers_;
  if (given("--tcp")) options.tcp = tcp_;
  if (given("--tag")) options.tag = tag_;
  if (given("--prefix")) settings.prefix = prefix_;
  options.lease = parse_duration_or(lease_, options.lease);
  settings.patience = parse_duration_or(patience_, settings.patience);
  settings.json = json_;
  return settings;
}

void AsOptions::add_to(CLI::App& app) {
  app.add_option("--name", name_, "name of this component");
  app.add_option("--id", id_, "id of this component, above 65535; random by default")
      ->type_name("ID")
      ->check(CLI::Range(model::kMaxIslandId + 4U, 0xffffffffU).description(""));
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
