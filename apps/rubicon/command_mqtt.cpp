#include <fmt/format.h>

#include <csignal>

#include "apps/program/last_seconds.h"
#include "apps/rubicon/cli.h"
#include "apps/rubicon/loop_component.h"
#include "apps/rubicon/tuple_text.h"
#include "bridges/bridge.h"
#include "transport/asio_signals.h"

namespace rubicon::cli {

namespace {

struct MqttWish {
  std::string broker, user, password_file, ca, name = "mqtt";
  bool tls = false;
  std::string base, discovery, payload, names, page;
  std::vector<std::string> patterns, commands;
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

/// `HOST[:PORT]`, or the same as a map where there is more to say.
ConfigNode broker_node(const MqttWish& options) {
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

/// As a configuration has them: one place reads and checks them.
ConfigNode mqtt_config(const MqttWish& options) {
  auto config = map_node();
  config.entries.emplace_back("broker", broker_node(options));
  put_text(config, "base", options.base);
  put_text(config, "discovery", options.discovery);
  put_text(config, "payload", options.payload);
  put_text(config, "names", options.names);
  put_text(config, "page", options.page);
  if (!options.patterns.empty()) config.entries.emplace_back("patterns", list_node(options.patterns));
  if (!options.commands.empty()) config.entries.emplace_back("commands", list_node(options.commands));
  return config;
}

int mirror_to_broker(const Settings& settings, const MqttWish& wanted) {
  const auto config = mqtt_config(wanted);
  base::ConfigErrors errors;
  const auto& type = *bridges::find_bridge_type("mqtt");
  LoopComponent component;
  ConfigReader checked(config, "rubicon mqtt", errors);
  std::ignore = type.make(checked, "", nullptr);
  if (!errors.empty()) {
    print_error(errors.text());
    return kUsage;
  }
  auto options = settings.options;
  options.broker.all = true;  // it shows all islands
  if (const auto opened = component.open(options, "bridge " + wanted.name); !opened) {
    print_error(opened.error().text);
    return opened.error().code == ErrorCode::kInvalid ? kUsage : kFailed;
  }
  auto& loop = component.loop();
  const bridges::BridgeHost host{wanted.name, loop.scheduler(), component.space(), component.transports(),
                                 component.log()};
  ConfigReader reader(config, "rubicon mqtt", errors);
  auto bridge = type.make(reader, "", &host);
  bridge->start();
  const transport::Signals ends(loop, {SIGINT, SIGTERM}, [&loop] { loop.stop(); });
  loop.run();
  bridge.reset();
  program::end_within_seconds(kGood);
  return kGood;
}

}  // namespace

void add_mqtt(Cli& cli) {
  const auto [app, options] =
      cli.command_with<MqttWish>({"mqtt", "Show the islands that this host finds on an MQTT broker, until a signal",
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
  app->add_option("--pattern", options->patterns, "values to show (may be repeated); default: all of points")
      ->check(check_pattern)
      ->allow_extra_args(false);
  app->add_option("--commands", options->commands, "yes, no, or patterns of commands to take; default: no")
      ->allow_extra_args(false);
  app->add_option("--payload", options->payload, "text or json");
  app->add_option("--names", options->names, "keys or friendly");
  app->add_option("--page", options->page, "address of the page, for links to devices");
  app->add_option("--as", options->name, "name of this bridge")->capture_default_str();
}

}  // namespace rubicon::cli
