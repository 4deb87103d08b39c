#include "config/service_config.h"

#include <gmock/gmock.h>

#include "config/yaml.h"

namespace rubicon::config {
namespace {

using testing::HasSubstr;

std::optional<WebSetup> read_section(const std::string& section, base::ConfigErrors& errors) {
  auto root = parse_yaml("a: 1\nweb: " + section + "\n", "home.yaml");
  EXPECT_TRUE(root);
  if (!root) return std::nullopt;
  ConfigReader reader(*root, "", errors);
  return read_web(reader);
}

WebSetup good_web(const std::string& section) {
  base::ConfigErrors errors;
  auto setup = read_section(section, errors);
  EXPECT_TRUE(errors.empty()) << errors.text();
  return setup.value_or(WebSetup{});
}

TEST(WebConfig, WithoutTheSectionThereIsNoPage) {
  auto root = parse_yaml("a: 1\n", "home.yaml");
  ASSERT_TRUE(root);
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  EXPECT_FALSE(read_web(reader));
}

TEST(WebConfig, AnEmptySectionIsLoopback) {
  EXPECT_EQ(good_web("{}"), WebSetup{});
  EXPECT_EQ(good_web("{}").listen, (base::HostPort{"127.0.0.1", 8642}));
}

TEST(WebConfig, AllKeysAreRead) {
  const auto setup = good_web(
      "{listen: \"0.0.0.0:443\", tls: {certificate: web.pem, key: web.key}, tokens: {file: web.tokens}, hosts: "
      "[hall.lan], "
      "origins: [\"https://hall.lan\"], metrics: {patterns: [\"proxy.**\"]}, files: web/dist, compress: yes}");
  EXPECT_EQ(setup.listen, (base::HostPort{"0.0.0.0", 443}));
  EXPECT_EQ(setup.tls, (WebTls{"web.pem", "web.key"}));
  EXPECT_EQ(setup.tokens, "web.tokens");
  EXPECT_THAT(setup.hosts, testing::ElementsAre("hall.lan"));
  EXPECT_THAT(setup.origins, testing::ElementsAre("https://hall.lan"));
  EXPECT_EQ(setup.metrics.size(), 1U);
  EXPECT_EQ(setup.files, "web/dist");
  EXPECT_TRUE(setup.compress);
}

TEST(WebConfig, AddressesToListenOn) {
  EXPECT_EQ(parse_web_listen("8000"), (base::HostPort{"127.0.0.1", 8000}));
  EXPECT_EQ(parse_web_listen(":0"), (base::HostPort{"127.0.0.1", 0}));
  EXPECT_EQ(parse_web_listen("localhost:8000"), (base::HostPort{"127.0.0.1", 8000}));
  EXPECT_EQ(parse_web_listen("[::1]:8000"), (base::HostPort{"::1", 8000}));
  for (const auto* wrong : {"", "hall.lan:8000", "127.0.0.1", "127.0.0.1:", "::1:8000", "127.0.0.1:70000", "a b:1"})
    EXPECT_FALSE(parse_web_listen(wrong)) << wrong;
}

TEST(WebConfig, WhoListensForOthersNeedsTlsAndTokensOrSaysThatItTrustsTheLan) {
  const std::string tls = "tls: {certificate: a, key: b}", tokens = "tokens: {file: c}";
  for (const auto& more : {std::string(), ", " + tls, ", " + tokens}) {
    base::ConfigErrors errors;
    read_section("{listen: \"192.168.1.5:8642\"" + more + "}", errors);
    EXPECT_THAT(errors.text(), HasSubstr("home.yaml:2:15: web.listen: 192.168.1.5 can be reached by other hosts"))
        << more;
    EXPECT_THAT(errors.text(), HasSubstr("tls: {certificate: web.pem, key: web.key} and tokens: {file: web.tokens}"));
  }
  good_web("{listen: \"0.0.0.0:8642\", " + tls + ", " + tokens + "}");
  good_web("{listen: \"0.0.0.0:8642\", trust_lan: yes}");
  good_web("{listen: \"127.8.8.8:8642\"}");
  good_web("{listen: \"[::1]:8642\"}");
}

TEST(WebConfig, WhatIsWrongIsSaidWithItsPlace) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"{listen: hall}", "home.yaml:2:15: web.listen: expected an IP address and a port"},
      {"{tls: {certificate: a}}", "web.tls: 'key' is missing"},
      {"{tokens: {}}", "web.tokens: 'file' is missing"},
      {"{tokens: {file: \"\"}}", "web.tokens.file: empty path, expected a file"},
      {"{hosts: [\"a b\"]}", "web.hosts: 'a b': expected a name of this host"},
      {"{origins: [hall.lan]}", "web.origins: 'hall.lan': expected the beginning of an address"},
      {"{metrics: {patterns: [\"a..b\"]}}", "web.metrics.patterns: "},
      {"{compress: perhaps}", "web.compress: is 'perhaps', expected yes or no"},
      {"{port: 80}", "web: unknown key 'port'"},
  };
  for (const auto& [section, part] : cases) {
    base::ConfigErrors errors;
    read_section(section, errors);
    EXPECT_THAT(errors.text(), HasSubstr(part)) << section;
  }
}

}  // namespace
}  // namespace rubicon::config
