#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>

#include "apps/rubicon/live_island.h"
#include "support/keyring_writer.h"

namespace rubicon::cli {
namespace {

using nlohmann::json;
using support::KeyringElement;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// An interface of KNX IP Secure, in a network of its own, whose thermometer speaks each second.
class SecureDirectBus : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    const auto script = folder_.write("line.script", "group 1/2/7 9.001 21.5 every 1s\n");
    const auto passwords =
        folder_.write("interface.passwords", "device-password auth code\nuser 2 1.1.200 two\nuser 3 1.1.201 three\n");
    interface_ = std::make_unique<Process>(std::vector<std::string>{RUBICON_BINARY_DIR "/bin/knx-simulator", script,
                                                                    "--listen", "13671", "--secure", passwords});
    ASSERT_TRUE(interface_->line()) << interface_->errors();
  }
  std::string password_file(const std::string& name, const std::string& text) {
    const auto path = folder_.write(name, text + "\n");
    EXPECT_EQ(::chmod(path.c_str(), 0600), 0);
    return path;
  }
  std::string keyring(const std::string& user_password, const std::string& device_password = "auth code") {
    auto root = support::keyring_root();
    KeyringElement tunnel{"Interface"};
    tunnel.text("Type", "Tunneling").text("IndividualAddress", "1.1.200").text("Host", "1.1.0").text("UserID", "2");
    root.add(tunnel.password("Password", user_password).password("Authentication", device_password));
    return folder_.write("house.knxkeys", support::write_keyring(root, "ring word"));
  }
  /// `rubicon knx read` by a tunnel of its own.
  support::Outcome read(std::vector<std::string> more) {
    std::vector<std::string> words{"knx", "read", "1/2/7", "9.001", "--direct", "127.0.0.1:13671"};
    words.insert(words.end(), more.begin(), more.end());
    return rubicon(std::move(words));
  }

  PrivateNetwork alone_;
  Folder folder_;
  std::unique_ptr<Process> interface_;
};

TEST_F(SecureDirectBus, ToolsOpenASecureTunnelWithAKeyring) {
  const auto file = keyring("two"), password = password_file("house.password", "ring word");
  const auto value = read({"--keyring", file, "--password-file", password});
  EXPECT_EQ(value.code, 0) << value.errors;
  EXPECT_THAT(value.output, HasSubstr("21.5"));
  Process monitor({kProgram, "knx", "monitor", "--json", "--direct", "127.0.0.1:13671", "--keyring", file,
                   "--password-file", password, "--server", "1.1.0"});
  const auto line = monitor.line();
  ASSERT_TRUE(line) << monitor.errors();
  EXPECT_EQ(json::parse(*line)["address"], "1/2/7");
}

TEST_F(SecureDirectBus, TakesAnotherTunnelOfTheKeyring) {
  const auto password = password_file("house.password", "ring word");
  auto root = support::keyring_root();
  for (const auto& [address, user, word] : {std::array{"1.1.200", "2", "two"}, std::array{"1.1.201", "3", "three"}}) {
    KeyringElement tunnel{"Interface"};
    tunnel.text("Type", "Tunneling").text("IndividualAddress", address).text("Host", "1.1.0").text("UserID", user);
    root.add(tunnel.password("Password", word).password("Authentication", "auth code"));
  }
  const auto file = folder_.write("house.knxkeys", support::write_keyring(root, "ring word"));
  Process first({kProgram, "knx", "monitor", "--json", "--direct", "127.0.0.1:13671", "--keyring", file,
                 "--password-file", password});
  ASSERT_TRUE(first.line()) << first.errors();
  const auto second = read({"--keyring", file, "--password-file", password, "--tunnel-address", "1.1.201"});
  EXPECT_EQ(second.code, 0) << second.errors;
}

TEST_F(SecureDirectBus, SecuredGroupsAreWrittenThroughAnIslandOnly) {
  auto root = support::keyring_root();
  KeyringElement own{"Interface"}, other{"Interface"}, group{"Group"}, takes{"Group"}, groups{"GroupAddresses"};
  own.text("Type", "Tunneling").text("IndividualAddress", "1.1.200").text("Host", "1.1.0").text("UserID", "2");
  root.add(own.password("Password", "two").password("Authentication", "auth code"));
  other.text("Type", "Tunneling").text("IndividualAddress", "1.1.201").text("Host", "1.1.0");
  root.add(other.add(takes.text("Address", "8193").text("Senders", "1.1.200")));
  root.add(groups.add(group.text("Address", "8193").key("Key", std::string(32, '7'))));
  const auto file = folder_.write("house.knxkeys", support::write_keyring(root, "ring word"));
  const auto written = rubicon({"knx", "write", "4/0/1", "1.001", "on", "--direct", "127.0.0.1:13671", "--keyring",
                                file, "--password-file", password_file("house.password", "ring word")});
  EXPECT_EQ(written.code, 4) << "refused";
  EXPECT_THAT(written.errors, AllOf(HasSubstr("4/0/1 is secured"), HasSubstr("leave out --direct")));
}

TEST_F(SecureDirectBus, RefusalsOfTheInterfaceEndTheToolWithTheirReason) {
  const auto password = password_file("house.password", "ring word");
  const auto plain = read({"--knx-tcp"});
  EXPECT_EQ(plain.code, 1);
  EXPECT_THAT(plain.errors, HasSubstr("does it require KNX IP Secure?"));
  const auto user = read({"--keyring", keyring("three"), "--password-file", password});
  EXPECT_EQ(user.code, 1);
  EXPECT_THAT(user.errors, AllOf(HasSubstr("does not accept user 2"), Not(HasSubstr("three"))));
  const auto device = read({"--keyring", keyring("two", "another"), "--password-file", password});
  EXPECT_EQ(device.code, 1);
  EXPECT_THAT(device.errors, HasSubstr("is not the device"));
}

TEST_F(SecureDirectBus, AWrongOrMissingPasswordOfTheKeyringIsNamed) {
  const auto file = keyring("two");
  const auto wrong = read({"--keyring", file, "--password-file", password_file("wrong", "a guess")});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_THAT(wrong.errors, AllOf(HasSubstr("the password of the keyring is wrong"), Not(HasSubstr("a guess"))));
  const auto missing = read({"--keyring", file});
  EXPECT_EQ(missing.code, 2);
  EXPECT_THAT(missing.errors, HasSubstr("--password-file FILE, or RUBICON_KNX_PASSWORD"));
  ASSERT_EQ(::setenv("RUBICON_KNX_PASSWORD", "ring word", 1), 0);
  const auto given = read({"--keyring", file});
  ASSERT_EQ(::unsetenv("RUBICON_KNX_PASSWORD"), 0);
  EXPECT_EQ(given.code, 0) << given.errors;
}

TEST(DirectBusOptions, AKeyringBelongsToATunnelOfItsOwn) {
  EXPECT_EQ(rubicon({"knx", "read", "1/2/7", "--keyring", "house.knxkeys"}).code, 2);
  EXPECT_EQ(rubicon({"knx", "read", "1/2/7", "--direct", "127.0.0.1", "--password-file", "x"}).code, 2);
  EXPECT_EQ(rubicon({"knx", "read", "1/2/7", "--direct", "127.0.0.1", "--keyring", ""}).code, 2) << "never plain";
  EXPECT_EQ(rubicon({"knx", "read", "1/2/7", "--direct", "127.0.0.1", "--tunnel-address", "1.1.201"}).code, 2);
  EXPECT_THAT(rubicon({"complete", "--", "knx", "monitor", "--key"}).output, HasSubstr("--keyring"));
  EXPECT_THAT(rubicon({"manual"}).output, HasSubstr("with this keyring of ETS"));
}

}  // namespace
}  // namespace rubicon::cli
