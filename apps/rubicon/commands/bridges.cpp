#include <fmt/format.h>

#include <csignal>

#include "apps/program/process.h"
#include "apps/rubicon/cli.h"
#include "apps/rubicon/loop_component.h"
#include "base/config_reader.h"
#include "bridges/bridge.h"
#include "transport/asio_scheduler.h"

namespace rubicon::cli {

namespace {

/// What every bridge takes.
struct BridgeOptions {
  std::string name;
  std::vector<std::string> patterns, commands;
};

struct MqttBridgeOptions : BridgeOptions {
  std::string broker, user, password_file, ca;
  bool tls = false;
  std::string base, discovery, payload, names, page;
};

struct RosBridgeOptions : BridgeOptions {
  std::string domain, name_space, distribution, diagnostics, import;
  std::vector<std::string> interfaces, peers;
};

ConfigNode text_node(const std::string& text) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kScalar;
  node.text = text;
  return node;
}

ConfigNode list_node(const std::vector<std::string>& texts) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kList;
  for (const auto& text : texts) node.items.push_back(text_node(text));
  return node;
}

ConfigNode map_node() {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  return node;
}

void put_text(ConfigNode& to, const std::string& key, const std::string& text) {
  if (!text.empty()) to.entries.emplace_back(key, text_node(text));
}

void put_list(ConfigNode& to, const std::string& key, const std::vector<std::string>& texts) {
  if (!texts.empty()) to.entries.emplace_back(key, list_node(texts));
}

/// `HOST[:PORT]`, or the same as a map where there is more to say.
void put_shared(ConfigNode& to, const BridgeOptions& options) {
  put_list(to, "patterns", options.patterns);
  put_list(to, "commands", options.commands);
}

ConfigNode broker_node(const MqttBridgeOptions& options) {
  if (options.user.empty() && options.ca.empty() && !options.tls) return text_node(options.broker);
  auto broker = map_node();
  const auto colon = options.broker.rfind(':');
  put_text(broker, "host", options.broker.substr(0, colon));
  if (colon != options.broker.npos) put_text(broker, "port", options.broker.substr(colon + 1));
  put_text(broker, "user", options.user);
  put_text(broker, "password-file", options.password_file);
  if (options.tls || !options.ca.empty()) {
    auto tls = map_node();
    put_text(tls, "ca", options.ca);
    broker.entries.emplace_back("tls", options.ca.empty() ? text_node("yes") : tls);
  }
  return broker;
}

/// In the form of a configuration, so that one function reads and checks them.
ConfigNode mqtt_config(const MqttBridgeOptions& options) {
  auto config = map_node();
  config.entries.emplace_back("broker", broker_node(options));
  put_text(config, "base", options.base);
  put_text(config, "discovery", options.discovery);
  put_text(config, "payload", options.payload);
  put_text(config, "names", options.names);
  put_text(config, "page", options.page);
  put_shared(config, options);
  return config;
}

/// The bridge alone, as a component that shows all islands, until a signal.
int run_bridge(const Settings& settings, std::string_view type_name, const std::string& name,
               const ConfigNode& config) {
  base::ConfigErrors errors;
  const auto& type = *bridges::find_bridge_type(type_name);
  const auto what = fmt::format("rubicon {}", type_name);
  LoopComponent component;
  ConfigReader checked(config, what, errors);
  std::ignore = type.make(checked, "", nullptr);
  if (!errors.empty()) {
    print_error(errors.text());
    return kUsage;
  }
  auto options = settings.options;
  options.broker.all = true;  // it shows all islands
  if (const auto opened = component.open(options, "bridge " + name); !opened) {
    print_error(opened.error().text);
    return opened.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
  }
  auto& loop = component.loop();
  const bridges::BridgeHost host{name, loop.scheduler(), component.space(), component.transports(), component.log()};
  ConfigReader reader(config, what, errors);
  auto bridge = type.make(reader, "", &host);
  bridge->start();
  const transport::Signals ends(loop, {SIGINT, SIGTERM}, [&loop] { loop.stop(); });
  loop.run();
  bridge.reset();
  program::end_within_seconds(kGood);
  return kGood;
}

int mirror_to_broker(const Settings& settings, const MqttBridgeOptions& wanted) {
  return run_bridge(settings, "mqtt", wanted.name, mqtt_config(wanted));
}

int show_to_robots(const Settings& settings, const RosBridgeOptions& wanted) {
  auto config = map_node();
  put_text(config, "domain", wanted.domain);
  put_text(config, "namespace", wanted.name_space);
  put_text(config, "distribution", wanted.distribution);
  put_text(config, "diagnostics", wanted.diagnostics);
  put_text(config, "import", wanted.import);
  put_shared(config, wanted);
  put_list(config, "interfaces", wanted.interfaces);
  put_list(config, "peers", wanted.peers);
  return run_bridge(settings, "ros2", wanted.name, config);
}

void add_shared_options(CLI::App* app, BridgeOptions* options, const std::string& name) {
  options->name = name;
  app->add_option("--pattern", options->patterns, "values to show (may be repeated); default: all of points")
      ->check(check_pattern)
      ->allow_extra_args(false);
  app->add_option("--commands", options->commands, "yes, no, or patterns of commands to take; default: no")
      ->allow_extra_args(false);
  app->add_option("--as", options->name, "name of this bridge")->capture_default_str();
}

}  // namespace

void add_mqtt(Cli& cli) {
  const auto [app, options] = cli.command_with<MqttBridgeOptions>(
      {"mqtt", "Show the islands that this host finds on an MQTT broker, until a signal",
       "  rubicon mqtt localhost --discovery homeassistant\n"
       "  rubicon mqtt localhost --commands yes --pattern '6541:proxy.living.**'\n"},
      mirror_to_broker);
  app->add_option("BROKER", options->broker, "HOST[:PORT]")->required();
  app->add_option("--user", options->user, "user of the broker");
  app->add_option("--password-file", options->password_file, "file with the password of that user");
  app->add_flag("--tls", options->tls, "over TLS");
  app->add_option("--ca", options->ca, "over TLS, with this certificate authority (PEM)");
  app->add_option("--base", options->base, "first levels of the topics; default: rubicon");
  app->add_option("--discovery", options->discovery, "homeassistant, homeassistant-entities or none");
  app->add_option("--payload", options->payload, "text or json");
  app->add_option("--names", options->names, "keys or friendly");
  app->add_option("--page", options->page, "address of the page, for links to devices");
  add_shared_options(app, options, "mqtt");
}

void add_ros2(Cli& cli) {
  const auto [app, options] = cli.command_with<RosBridgeOptions>(
      {"ros2", "Show the islands that this host finds to ROS 2, and topics of robots as tuples, until a signal",
       "  rubicon ros2\n"
       "  rubicon ros2 --ros-interface any --ros-domain 7 --import auto\n"},
      show_to_robots);
  app->add_option("--ros-domain", options->domain, "0 to 232; default: ROS_DOMAIN_ID of the environment, else 0");
  app->add_option("--ros-interface", options->interfaces,
                  "name of a network interface, or any (may be repeated); default: lo, this host only")
      ->allow_extra_args(false);
  app->add_option("--ros-peer", options->peers, "HOST of a robot that multicast does not reach (may be repeated)")
      ->allow_extra_args(false);
  app->add_option("--namespace", options->name_space, "first level of the topics; default: the name of the island");
  app->add_option("--distribution", options->distribution, "auto, humble, jazzy or none; default: auto");
  app->add_option("--diagnostics", options->diagnostics, "period of /diagnostics, or never; default: 1s");
  app->add_option("--import", options->import, "auto: topics of robots become tuples; default: no");
  add_shared_options(app, options, "ros2");
}

}  // namespace rubicon::cli
