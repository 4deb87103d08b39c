#include "base/log.h"

#include <gtest/gtest.h>

namespace rubicon::base {
namespace {

TEST(Masked, NamesOfSecretsAreKnownAndPathsAreNone) {
  for (const auto* name : {"password", "Password", "broker.password", "passphrase", "client-secret", "token", "tokens",
                           "api-key", "network_key", "key", "tls.key"})
    EXPECT_TRUE(names_secret(name)) << name;
  for (const auto* name : {"password-file", "password-env", "tokens-file", "keys", "keyboard", "monkey", "user", ""})
    EXPECT_FALSE(names_secret(name)) << name;
}

TEST(Masked, ValuesOfSecretsAreReplacedAndNothingElse) {
  const std::pair<const char*, const char*> cases[] = {
      {"the line is up", "the line is up"},
      {"--set \"networks.zigbee.broker.password=abc\": no", "--set \"networks.zigbee.broker.password=****\": no"},
      {"password: 'two words', user: anna", "password: ****, user: anna"},
      {"{token: abc, port: 1}", "{token: ****, port: 1}"},
      {"mqtt://anna:geheim@host:1883/x", "mqtt://anna:****@host:1883/x"},
      {"mqtt://host:1883/a@b", "mqtt://host:1883/a@b"},
      {"Authorization: Bearer abc.def", "Authorization: Bearer ****"},
      {"a password is missing", "a password is missing"},
      {"password-file: /etc/x", "password-file: /etc/x"},
      {"token=", "token="},
      {"password=\"open", "password=****"},
      {"", ""},
  };
  for (const auto& [text, expected] : cases) EXPECT_EQ(masked(text), expected);
}

}  // namespace
}  // namespace rubicon::base
