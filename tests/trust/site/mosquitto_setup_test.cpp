#include "trust/site/brokers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace rubicon::trust::site {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> lines_in(const std::string& text) {
  std::istringstream all(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(all, line);) {
    if (!line.empty() && !line.starts_with('#')) lines.push_back(line);
  }
  return lines;
}

const MosquittoSetup kSetup{"/etc/rubicon/broker/main", "/var/lib/rubicon-broker/main", "rubicon-broker", 8883, false};

TEST(MosquittoSetup, HasEachSettingThatMembersNeed) {
  const auto lines = lines_in(mosquitto_conf(kSetup));
  for (const auto* line :
       {"listener 8883", "cafile /etc/rubicon/broker/main/ca.pem", "certfile /etc/rubicon/broker/main/broker.pem",
        "keyfile /etc/rubicon/broker/main/broker.key", "crlfile /etc/rubicon/broker/main/crl.pem",
        "require_certificate true", "use_identity_as_username true", "allow_anonymous false",
        "acl_file /etc/rubicon/broker/main/acl", "persistence true",
        "persistence_location /var/lib/rubicon-broker/main/", "autosave_interval 30", "max_queued_messages 100000",
        "set_tcp_nodelay true", "message_size_limit 2097152", "user rubicon-broker",
        "include_dir /etc/rubicon/broker/main/conf.d"})
    EXPECT_THAT(lines, Contains(line));
  EXPECT_THAT(mosquitto_conf(kSetup), Not(HasSubstr("password_file")));
}

TEST(MosquittoSetup, PasswordsHaveAListenerOfTheirOwn) {
  auto setup = kSetup;
  setup.takes_passwords = true;
  const auto lines = lines_in(mosquitto_conf(setup));
  EXPECT_THAT(lines, Contains("listener 8884"));
  EXPECT_THAT(lines, Contains("password_file /etc/rubicon/broker/main/passwords"));
  EXPECT_THAT(lines, Contains("allow_anonymous false"));
}

TEST(MosquittoSetup, HasTheFourRightsAndNothingForWhoIsRevoked) {
  EXPECT_THAT(lines_in(mosquitto_acl({"desk"})),
              ElementsAre("pattern read rubicon-space/1/+/p/#", "pattern write rubicon-space/1/+/p/+/%u/#",
                          "pattern read rubicon-space/1/+/to/%u/#", "pattern write rubicon-space/1/+/to/+/+/%u/+",
                          "user desk", "topic deny #"));
}

}  // namespace
}  // namespace rubicon::trust::site
