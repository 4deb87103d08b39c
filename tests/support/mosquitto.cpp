#include "support/mosquitto.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

namespace rubicon::support {

namespace {

namespace fs = std::filesystem;

std::string own_folder(const std::string& what) {
  static std::atomic<int> count = 0;
  const auto path = fs::temp_directory_path() / fmt::format("rubicon-{}-{}-{}", what, ::getpid(), ++count);
  fs::create_directories(path);
  return path.string();
}

void remove_folder(const std::string& path) {
  std::error_code ignored;
  fs::remove_all(path, ignored);
}

constexpr auto kMakeCertificates = R"(
  cd "$0"
  new="-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes"
  for ca in ca other_ca; do
    openssl req -x509 $new -keyout $ca.key -out $ca.pem -subj "/CN=$ca" -days 30
  done
  sign() {
    openssl req $new -keyout $1.key -out $1.csr -subj "/CN=$2" -addext "subjectAltName=DNS:$2"
    openssl x509 -req -in $1.csr -CA ca.pem -CAkey ca.key -CAcreateserial -out $1.pem -days 30 -copy_extensions copy
  }
  sign server broker.test
  sign client rubicon
  openssl ec -in client.key -aes256 -passout pass:secret -out encrypted.key
  openssl pkcs8 -topk8 -in client.key -passout pass:secret -out encrypted.pkcs8
)";

/// Of mosquitto's own plug-in, which refuses subscriptions; an acl_file does not.
std::string security_plugin() {
  for (const auto& entry : fs::directory_iterator("/usr/lib")) {
    const auto path = entry.path() / "mosquitto_dynamic_security.so";
    std::error_code ignored;
    if (fs::exists(path, ignored)) return path.string();
  }
  return "mosquitto_dynamic_security.so";
}

}  // namespace

Certificates::Certificates() : folder_(own_folder("certificates")) {
  const auto made = run_to_end({"sh", "-ec", kMakeCertificates, folder_});
  if (made.code != 0) reason_ = "no certificates: " + made.errors;
}

Certificates::~Certificates() {
  remove_folder(folder_);
}

std::string Mosquitto::missing() {
  for (const auto* program : {"mosquitto", "mosquitto_pub", "mosquitto_sub", "mosquitto_passwd"}) {
    if (run_to_end({"sh", "-c", std::string("command -v ") + program}).code != 0)
      return fmt::format("the program {} is not installed", program);
  }
  return {};
}

Mosquitto::Mosquitto(MosquittoOptions options) : options_(std::move(options)), folder_(own_folder("mosquitto")) {
  write_users();
  write_security();
  if (!options_.acl.empty()) std::ofstream(folder_ + "/acl") << options_.acl;
  std::ofstream(folder_ + "/mosquitto.conf") << configuration();
  start();
}

Mosquitto::~Mosquitto() {
  process_.reset();
  remove_folder(folder_);
}

std::string Mosquitto::configuration() const {
  auto text =
      fmt::format("user root\nlistener {} 127.0.0.1\nallow_anonymous {}\n", options_.port, options_.users.empty());
  if (!options_.users.empty()) text += fmt::format("password_file {}/users\n", folder_);
  if (!options_.acl.empty()) text += fmt::format("acl_file {}/acl\n", folder_);
  if (const auto* tls = options_.tls)
    text += fmt::format("cafile {}\ncertfile {}\nkeyfile {}\nrequire_certificate {}\n", tls->path("ca.pem"),
                        tls->path("server.pem"), tls->path("server.key"), options_.asks_for_certificate);
  if (options_.persistent) text += fmt::format("persistence true\npersistence_location {}/\n", folder_);
  if (!options_.refused_filters.empty() || !options_.forbidden_topics.empty())
    text += fmt::format("plugin {}\nplugin_opt_config_file {}/security.json\n", security_plugin(), folder_);
  return text + options_.more;
}

void Mosquitto::write_users() const {
  const auto file = folder_ + "/users";
  std::ofstream(file).close();
  for (const auto& [user, password] : options_.users) run_to_end({"mosquitto_passwd", "-b", file, user, password});
}

void Mosquitto::write_security() const {
  std::string rules;
  const auto add = [&](const char* type, const std::string& topic) {
    rules += fmt::format(R"({}{{"acltype":"{}","topic":"{}","allow":false}})", rules.empty() ? "" : ",", type, topic);
  };
  for (const auto& filter : options_.refused_filters) add("subscribePattern", filter);
  for (const auto& topic : options_.forbidden_topics) add("publishClientSend", topic);
  std::ofstream(folder_ + "/security.json") << fmt::format(
      R"({{"defaultACLAccess":{{"publishClientSend":true,"publishClientReceive":true,"subscribe":true,"unsubscribe":true}},
"clients":[],"groups":[{{"groupname":"all","roles":[{{"rolename":"r"}}],"clients":[]}}],"anonymousGroup":"all",
"roles":[{{"rolename":"r","acls":[{}]}}]}})",
      rules);
}

void Mosquitto::start() {
  process_ = std::make_unique<Process>(std::vector<std::string>{"mosquitto", "-c", folder_ + "/mosquitto.conf"});
}

void Mosquitto::kill() {
  process_.reset();
}

void Mosquitto::stop() {
  if (process_) process_->signal(SIGTERM);
  if (process_) process_->exit_code();
  process_.reset();
}

bool Mosquitto::ready() const {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options_.port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const bool there = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(probe);
  return there;
}

bool Mosquitto::comes_up() const {
  for (int i = 0; i < 3000 && !ready(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  return ready();
}

Outcome Mosquitto::publish(const std::string& topic, const std::string& payload, std::vector<std::string> more) const {
  std::vector<std::string> all{"mosquitto_pub", "-h", "127.0.0.1", "-p", std::to_string(options_.port), "-t", topic};
  if (more.empty() || more.front() != "-f") all.insert(all.end(), {"-m", payload});
  all.insert(all.end(), more.begin(), more.end());
  return run_to_end(std::move(all));
}

MosquittoListener::MosquittoListener(const Mosquitto& broker, const std::string& filter)
    : process_({"stdbuf", "-oL", "mosquitto_sub", "-h", "127.0.0.1", "-p", std::to_string(broker.port()), "-v", "-d",
                "-t", filter}) {
  process_.line_with("Subscribed");
}

/// Between the messages it tells what it does: `Client null received ...`.
std::optional<std::string> MosquittoListener::next() {
  auto line = process_.line();
  while (line && line->starts_with("Client ")) line = process_.line();
  return line;
}

}  // namespace rubicon::support
