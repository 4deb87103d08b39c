#pragma once

#include "ecology/sites.h"

namespace rubicon::ecology {

/// A realm, and a broker that is never told what changes: members find it out themselves.
class RealmOfSites : public SitesOfABroker {
 protected:
  void make_realm(bool passwords = false) {
    trust("authority", {"init", "--broker", "127.0.0.1"});
    std::vector<std::string> words{"broker", "mosquitto", "--out", folder_ / "broker"};
    if (passwords) words.emplace_back("--passwords");
    trust("authority", words);
    trust("authority", {"add", "hall", "--here", "--island", "1"});
  }
  void start_broker() {
    broker_ = std::make_unique<support::Process>(
        std::vector<std::string>{"mosquitto", "-c", folder_ / "broker/mosquitto.conf"});
  }
  support::Outcome trust(const std::string& host, std::vector<std::string> words) {
    words.insert(words.begin(), "trust");
    words.insert(words.end(), {"--realm", folder_ / (host + "-realm")});
    auto outcome = run(host, std::move(words));
    EXPECT_EQ(outcome.code, 0) << outcome.output << outcome.errors;
    return outcome;
  }
  /// A member on a host of its own, with the realm as it is now.
  void join(const std::string& name, const std::vector<std::string>& more) {
    const auto file = folder_ / (name + ".trust"), phrase = folder_ / (name + ".phrase");
    std::vector<std::string> words{"add", name, "--out", file, "--phrase-file", phrase};
    words.insert(words.end(), more.begin(), more.end());
    trust("authority", words);
    trust(name, {"join", file, "--yes", "--phrase-file", phrase});
  }
  std::string mqtt(const std::string& member, const std::string& host) const {
    const auto realm = folder_ / (host + "-realm");
    const auto of = realm + "/members/" + member;
    return "{broker: {host: 127.0.0.1, port: 8883, tls: {ca: " + realm + "/ca.pem, certificate: " + of +
           "/certificate.pem, key: " + of + "/key.pem}}}";
  }
  std::string mqtt(const std::string& member) const { return mqtt(member, member); }
  std::string tool(const std::string& name, const std::string& mqtt_lines) const {
    const auto file = folder_ / (name + ".yaml");
    std::ofstream(file) << "tuples: {mqtt: " << mqtt_lines << "}\n";
    return file;
  }
  static int sequence(support::Process& island, const std::string& key) {
    return support::ask(island, "get " + key).value("sequence", -1);
  }
  static testing::AssertionResult reaches(support::Process& island, const std::string& key, int sequence) {
    return support::until(island, "get " + key, std::chrono::seconds(60),
                          [&](const nlohmann::json& tuple) { return tuple.value("sequence", -1) >= sequence; });
  }

  std::unique_ptr<support::Process> broker_;
};

}  // namespace rubicon::ecology
