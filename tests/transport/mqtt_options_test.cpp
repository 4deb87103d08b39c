#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/config_text.h"
#include "support/memory/memory_transports.h"
#include "transport/mqtt_options.h"

namespace rubicon::transport {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

struct ReadBroker {
  MqttBrokerOptions options;
  std::string errors;
};

ReadBroker read(std::string_view json) {
  const auto node = support::config_of(json);
  ConfigErrors errors;
  ConfigReader reader(node, "networks.zigbee", errors);
  auto options = read_mqtt_broker(reader, "/etc/rubicon");
  reader.finish();
  return {std::move(options), errors.text()};
}

TEST(MqttBrokerOption, IsAHostOrAMap) {
  const auto plain = read(R"({"broker": "broker.lan"})");
  EXPECT_EQ(plain.errors, "");
  EXPECT_EQ(plain.options.line.host, "broker.lan");
  EXPECT_EQ(plain.options.line.port, 1883);
  EXPECT_EQ(read(R"({"broker": "[::1]:18830"})").options.line.port, 18830);
  const auto full = read(R"({"broker": {"host": "b", "tls": {"ca": "ca.pem", "certificate": "/c.pem", "key": "k.pem",
      "server-name": "x"}, "user": "rubicon", "password-file": "pw", "version": "3.1.1", "largest-packet": "1MiB"}})");
  EXPECT_EQ(full.errors, "");
  const auto& line = full.options.line;
  EXPECT_EQ(line.port, 8883);
  ASSERT_TRUE(line.tls);
  EXPECT_EQ(line.tls->ca_file, "/etc/rubicon/ca.pem");
  EXPECT_EQ(line.tls->certificate_file, "/c.pem");
  EXPECT_EQ(line.tls->server_name, "x");
  EXPECT_EQ(line.version, MqttVersion::k311);
  EXPECT_EQ(line.largest_packet, 1U << 20U);
  EXPECT_EQ(full.options.password_file, "/etc/rubicon/pw");
  EXPECT_EQ(full.options.files().size(), 4U);
  EXPECT_TRUE(read(R"({"broker": {"host": "b", "tls": "yes"}})").options.line.tls);
  EXPECT_FALSE(read(R"({"broker": {"host": "b", "tls": "no", "port": 1}})").options.line.tls);
}

TEST(MqttBrokerOption, SaysWhatIsWrongAndWhatIsExpected) {
  const auto fault = [](std::string_view json) { return read(json).errors; };
  EXPECT_THAT(fault(R"({})"), HasSubstr("'broker' is missing, expected HOST[:PORT]"));
  EXPECT_THAT(fault(R"({"broker": "a:b:c"})"), HasSubstr("networks.zigbee.broker: is 'a:b:c', expected HOST[:PORT]"));
  EXPECT_THAT(fault(R"({"broker": ["a"]})"), HasSubstr("expected"));
  EXPECT_THAT(fault(R"({"broker": {"port": 1}})"), HasSubstr("'host' is missing"));
  EXPECT_THAT(fault(R"({"broker": {"host": "a", "prot": 1}})"), HasSubstr("unknown key 'prot'"));
  EXPECT_THAT(fault(R"({"broker": {"host": "a", "tls": {"key": "k"}}})"), HasSubstr("expected both or none"));
  EXPECT_THAT(fault(R"({"broker": {"host": "a", "user": "u", "password-file": "f", "password-env": "E"}})"),
              HasSubstr("either password-file or password-env"));
  EXPECT_THAT(fault(R"({"broker": {"host": "a", "password-env": "E"}})"), HasSubstr("expected 'user' too"));
  EXPECT_THAT(fault(R"({"broker": {"host": "a", "version": "4"}})"), HasSubstr("any, 5, 3.1.1"));
}

TEST(MqttBrokerOption, APasswordInTheFileIsRefusedAndNeverRepeated) {
  const auto plain = read(R"({"broker": {"host": "a", "user": "u", "password": "s3cret"}})").errors;
  EXPECT_THAT(plain, HasSubstr("name that file in password-file"));
  EXPECT_THAT(plain, Not(HasSubstr("s3cret")));
  const auto url = read(R"({"broker": "mqtt://u:s3cret@host"})").errors;
  EXPECT_THAT(url, HasSubstr("is a URL, expected HOST[:PORT]"));
  EXPECT_THAT(url, Not(HasSubstr("s3cret")));
}

TEST(MqttBrokerOption, PasswordsAreReadWhenALineIsOpened) {
  MemoryTransports files;
  auto read_file = read(R"({"broker": {"host": "a", "user": "u", "password-file": "pw"}})").options;
  EXPECT_EQ(read_file.with_password(files).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_file.password_warning(files), "");
  files.put("/etc/rubicon/pw", "s3cret \r\n");
  EXPECT_EQ(read_file.with_password(files)->password, "s3cret ");
  EXPECT_EQ(read_file.password_warning(files), "");
  files.open_to_all("/etc/rubicon/pw");
  EXPECT_TRUE(read_file.with_password(files));
  EXPECT_EQ(read_file.password_warning(files),
            "/etc/rubicon/pw: all users of this machine can read this password; run chmod 600");
  for (const auto* wrong : {"", "\n", "two\nlines\n"}) {
    files.put("/etc/rubicon/pw", wrong);
    const auto refused = read_file.with_password(files);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_THAT(refused.error().text, HasSubstr("expected one line with the password"));
  }
  const auto variable = read(R"({"broker": {"host": "a", "user": "u", "password-env": "RUBICON_TEST_PW"}})").options;
  ::unsetenv("RUBICON_TEST_PW");
  EXPECT_THAT(variable.with_password(files).error().text, HasSubstr("RUBICON_TEST_PW (password-env) is not set"));
  ::setenv("RUBICON_TEST_PW", "other", 1);
  EXPECT_EQ(variable.with_password(files)->password, "other");
}

}  // namespace
}  // namespace rubicon::transport
