#include "transport/mqtt_options.h"

#include <fmt/format.h>

#include <cstdlib>

#include "base/text.h"
#include "transport/transports.h"

namespace rubicon::transport {

namespace {

constexpr std::uint16_t kPlainPort = 1883, kTlsPort = 8883;
constexpr std::size_t kMaxPassword = 65535;  // MQTT 5, section 3.1.3.6

constexpr auto kNoPasswordHere =
    "a password must not be in this file: write it into a file that only the user of the program can read, and name "
    "that file in password-file, or name an environment variable in password-env";
constexpr auto kNoUrl = "is a URL, expected HOST[:PORT] or a map (host, port, tls, user, password-file, ...)";

/// A URL may have a password in it: it is not repeated.
void read_address(ConfigReader& options, const std::string& key, MqttOptions& line) {
  const auto text = options.text(key, {});
  if (text.find("://") != text.npos || text.find('@') != text.npos) return options.error(key, kNoUrl);
  const auto address = base::parse_host_port(text, kPlainPort);
  if (!address || address->host.empty()) {
    return options.error(key, fmt::format("is '{}', expected HOST[:PORT], such as broker.lan or 192.168.1.5:1883",
                                          base::one_line(text.substr(0, 60))));
  }
  if (const auto fault = base::host_fault(address->host); !fault.empty()) options.error(key, fault);
  line.host = address->host;
  line.port = address->port;
}

std::string read_path(ConfigReader& map, const std::string& key, const std::string& directory) {
  const auto text = map.text(key, {});
  if (map.has(key) && text.empty()) map.error(key, "is empty, expected the path of a file");
  return text.empty() ? text : base::resolve_path(directory, text);
}

std::optional<MqttTls> read_tls(ConfigReader& map, const std::string& directory) {
  const auto* node = map.node("tls");
  if (node == nullptr) return std::nullopt;
  if (node->kind == ConfigNode::Kind::kScalar)
    return map.boolean("tls", false) ? std::optional(MqttTls{}) : std::nullopt;
  auto tls = map.map("tls");
  MqttTls found;
  found.ca_file = read_path(tls, "ca", directory);
  found.certificate_file = read_path(tls, "certificate", directory);
  found.key_file = read_path(tls, "key", directory);
  found.server_name = tls.text("server-name", {});
  if (found.certificate_file.empty() != found.key_file.empty())
    tls.error("", "has one of 'certificate' and 'key', expected both or none");
  tls.finish();
  return found;
}

void read_user(ConfigReader& map, const std::string& directory, MqttBrokerOptions& found) {
  found.line.user = map.text("user", {});
  found.password_file = read_path(map, "password-file", directory);
  found.password_variable = map.text("password-env", {});
  if (map.node("password") != nullptr) map.error("password", kNoPasswordHere);
  if (!found.password_file.empty() && !found.password_variable.empty())
    map.error("password-env", "expected either password-file or password-env");
  const bool password = map.has("password-file") || map.has("password-env");
  if (password && found.line.user.empty()) map.error("", "has a password and no user, expected 'user' too");
}

MqttVersion read_version(ConfigReader& map) {
  const auto version = map.choice("version", "any", {"any", "5", "3.1.1"});
  return version == "5" ? MqttVersion::k5 : version == "3.1.1" ? MqttVersion::k311 : MqttVersion::kAny;
}

void read_map(ConfigReader& map, const std::string& directory, MqttBrokerOptions& found) {
  found.line.host = map.required_text("host", "the name or address of the broker, such as 192.168.1.20");
  if (const auto fault = base::host_fault(found.line.host); map.has("host") && !fault.empty()) map.error("host", fault);
  found.line.tls = read_tls(map, directory);
  found.line.port = static_cast<std::uint16_t>(map.integer("port", found.line.tls ? kTlsPort : kPlainPort, 1, 65535));
  read_user(map, directory, found);
  found.line.version = read_version(map);
  found.line.largest_packet =
      map.size("largest-packet", found.line.largest_packet, std::size_t{64} << 10U, std::size_t{256} << 20U);
  map.finish();
}

Result<std::string> password_in(std::string text, const std::string& where) {
  const auto end = text.find_first_of("\r\n");
  const bool more = end != text.npos && text.find_first_not_of("\r\n", end) != text.npos;
  if (end == 0 || text.empty() || more)
    return fail(ErrorCode::kInvalid, fmt::format("{}: expected one line with the password", where));
  text.resize(std::min(end, text.size()));
  return text;
}

Result<std::string> read_password_file(Transports& transports, const std::string& path) {
  auto text = read_text(transports, path, kMaxPassword);
  if (!text) return fail(text.error());
  return password_in(std::move(*text), path);
}

Result<std::string> read_password_variable(const std::string& name) {
  const char* value = std::getenv(name.c_str());
  if (value == nullptr)
    return fail(ErrorCode::kNotFound, fmt::format("the environment variable {} (password-env) is not set", name));
  return password_in(value, fmt::format("environment variable {}", name));
}

}  // namespace

MqttBrokerOptions read_mqtt_broker(ConfigReader& options, const std::string& directory, const std::string& key) {
  MqttBrokerOptions found;
  const auto* node = options.node(key);
  if (node == nullptr) {
    options.error("", fmt::format("'{}' is missing, expected HOST[:PORT] of the MQTT broker, or a map", key));
  } else if (node->kind == ConfigNode::Kind::kMap) {
    auto map = options.map(key);
    read_map(map, directory, found);
  } else {
    read_address(options, key, found.line);
  }
  return found;
}

Result<MqttOptions> MqttBrokerOptions::with_password(Transports& transports) const {
  MqttOptions options = line;
  if (password_file.empty() && password_variable.empty()) return options;
  auto password =
      password_file.empty() ? read_password_variable(password_variable) : read_password_file(transports, password_file);
  if (!password) return fail(password.error());
  options.password = std::move(*password);
  return options;
}

std::string MqttBrokerOptions::password_warning(Transports& transports) const {
  if (password_file.empty()) return {};
  const auto file = transports.open_file(password_file);
  if (!file || !(*file)->open_to_all()) return {};
  return fmt::format("{}: all users of this machine can read this password; run chmod 600", password_file);
}

std::vector<MqttBrokerOptions::File> MqttBrokerOptions::files() const {
  std::vector<File> all{{"password-file", password_file}};
  if (line.tls) {
    all.push_back({"tls.ca", line.tls->ca_file});
    all.push_back({"tls.certificate", line.tls->certificate_file});
    all.push_back({"tls.key", line.tls->key_file});
  }
  std::erase_if(all, [](const auto& file) { return file.path.empty(); });
  return all;
}

}  // namespace rubicon::transport
