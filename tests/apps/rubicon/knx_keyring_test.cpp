#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>

#include "apps/rubicon/live_island.h"
#include "support/keyring_writer.h"

namespace rubicon::cli {
namespace {

using nlohmann::json;
using support::KeyringElement;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kRingPassword = "ring word";
constexpr const char* kSecretKey = "303132333435363738393a3b3c3d3e3f";

KeyringElement hall() {
  auto root = support::keyring_root("Hall");
  root.add(KeyringElement{"Backbone"}
               .text("MulticastAddress", "224.0.23.77")
               .text("Latency", "1500")
               .key("Key", kSecretKey));
  root.add(KeyringElement{"Interface"}
               .text("Type", "Tunneling")
               .text("IndividualAddress", "1.1.10")
               .text("Host", "1.1.0")
               .text("UserID", "2")
               .password("Password", "tunnel secret")
               .password("Authentication", "device secret")
               .add(KeyringElement{"Group"}.text("Address", "2567").text("Senders", "1.1.11 1.1.30")));
  root.add(KeyringElement{"Interface"}
               .text("Type", "Tunneling")
               .text("IndividualAddress", "1.1.11")
               .text("Host", "1.1.0")
               .text("UserID", "3")
               .password("Password", "tunnel secret")
               .add(KeyringElement{"Group"}.text("Address", "2567").text("Senders", "1.1.10 1.1.30")));
  root.add(
      KeyringElement{"GroupAddresses"}.add(KeyringElement{"Group"}.text("Address", "2567").key("Key", kSecretKey)));
  root.add(KeyringElement{"Devices"}.add(KeyringElement{"Device"}
                                             .text("IndividualAddress", "1.1.30")
                                             .key("ToolKey", kSecretKey)
                                             .password("ManagementPassword", "management secret")
                                             .text("SequenceNumber", "4294967297")));
  return root;
}

struct KnxKeyring : ::testing::Test {
  KnxKeyring() : file(folder.write("hall.knxkeys", support::write_keyring(hall(), kRingPassword))) {
    password = password_file("hall.password", std::string(kRingPassword) + "\n");
  }
  std::string password_file(const std::string& name, const std::string& text, mode_t mode = 0600) {
    const auto path = folder.write(name, text);
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    return path;
  }
  Folder folder;
  std::string file, password;
};

TEST_F(KnxKeyring, ShowsWhatIsInItAndWhatIsPickedButNoSecret) {
  const auto shown = rubicon({"knx", "keyring", file, "--password-file", password});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  EXPECT_EQ(shown.output,
            "project    Hall, test, 2026-11-20T23:50:00\n"
            "signature  good\n"
            "backbone   224.0.23.77, latency 1500 ms; secrets: key\n"
            "interface  1.1.10 Tunneling of 1.1.0, user 2; secrets: password, authentication code\n"
            "  group    1/2/7 takes telegrams of 1.1.11 1.1.30\n"
            "interface  1.1.11 Tunneling of 1.1.0, user 3; secrets: password\n"
            "  group    1/2/7 takes telegrams of 1.1.10 1.1.30\n"
            "group      1/2/7; secrets: key\n"
            "device     1.1.30; secrets: tool key, management password; sequence number 4294967297\n"
            "picked     tunnel 1.1.10 of 1.1.0, user 2\n"
            "  group    1/2/7 read and write, senders: 2\n");
}

TEST_F(KnxKeyring, AsJsonItHasTheSame) {
  const auto shown = rubicon({"--json", "knx", "keyring", file, "--password-file", password, "--tunnel", "1.1.11"});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  const auto line = lines_of(shown).at(0);
  EXPECT_EQ(line["signature"], "good");
  EXPECT_EQ(line["backbone"], (json{{"group", "224.0.23.77"}, {"latency-ms", 1500}, {"key", true}}));
  EXPECT_EQ(line["interfaces"][0]["groups"][0], (json{{"address", "1/2/7"}, {"senders", {"1.1.11", "1.1.30"}}}));
  EXPECT_EQ(line["interfaces"][1]["authentication"], false);
  EXPECT_EQ(line["devices"][0]["sequence"], 4294967297);
  const auto& picked = line["picked"].at(0);
  EXPECT_EQ(picked["tunnel"], "1.1.11");
  EXPECT_EQ(picked["user"], 3);
  EXPECT_EQ(picked["authentication"], false);
  EXPECT_EQ(picked["groups"],
            json::array({{{"address", "1/2/7"}, {"write", true}, {"senders", json::array({"1.1.10", "1.1.30"})}}}));
  for (const auto* secret : {"tunnel secret", "device secret", "management secret", kRingPassword, kSecretKey})
    EXPECT_THAT(shown.output, Not(HasSubstr(secret)));
}

TEST_F(KnxKeyring, WithoutAPasswordTheSignatureIsNotChecked) {
  const auto shown = rubicon({"knx", "keyring", file});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  EXPECT_THAT(shown.output, AllOf(HasSubstr("not checked: no password was given"), Not(HasSubstr("picked"))));
  EXPECT_EQ(lines_of(rubicon({"--json", "knx", "keyring", file})).at(0)["signature"], "not-checked");
}

TEST_F(KnxKeyring, ThePasswordMayComeFromTheEnvironment) {
  ASSERT_EQ(::setenv("RUBICON_KNX_PASSWORD", kRingPassword, 1), 0);
  const auto shown = rubicon({"knx", "keyring", file});
  ASSERT_EQ(::unsetenv("RUBICON_KNX_PASSWORD"), 0);
  EXPECT_THAT(shown.output, HasSubstr("signature  good"));
}

TEST_F(KnxKeyring, AWrongPasswordAndAChangedFileHaveDifferentErrors) {
  const auto wrong = rubicon({"knx", "keyring", file, "--password-file", password_file("wrong", "a guess")});
  EXPECT_EQ(wrong.code, 1);
  EXPECT_EQ(wrong.output, "");
  EXPECT_THAT(wrong.errors,
              AllOf(HasSubstr("hall.knxkeys: the password of the keyring is wrong (the password is from "),
                    Not(HasSubstr("a guess"))));
  auto text = support::write_keyring(hall(), kRingPassword);
  text.replace(text.find("1500"), 4, "1501");
  const auto changed = rubicon({"knx", "keyring", folder.write("changed.knxkeys", text), "--password-file", password});
  EXPECT_EQ(changed.code, 1);
  EXPECT_THAT(changed.errors, HasSubstr("was changed after ETS exported it"));
}

TEST_F(KnxKeyring, APasswordFileThatOthersMayReadIsRefused) {
  const auto open = password_file("open.password", kRingPassword, 0644);
  const auto refused = rubicon({"knx", "keyring", file, "--password-file", open});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.output, "");
  EXPECT_THAT(refused.errors, HasSubstr("chmod 600 " + open));
}

TEST_F(KnxKeyring, SaysWhyNoTunnelCanBePicked) {
  const auto none = rubicon({"knx", "keyring", file, "--password-file", password, "--tunnel", "1.1.99"});
  EXPECT_EQ(none.code, 1);
  EXPECT_THAT(none.output, HasSubstr("picked     no tunnel: the keyring has no tunnel 1.1.99, only: 1.1.10, 1.1.11"));
  const auto picked = rubicon({"knx", "keyring", file, "--password-file", password, "--server", "1.1.0"});
  EXPECT_THAT(picked.output, HasSubstr("picked     tunnel 1.1.10 of 1.1.0, user 2"));
  EXPECT_EQ(rubicon({"knx", "keyring", file, "--password-file", password, "--tunnel", "x"}).code, 1);
}

TEST_F(KnxKeyring, ATunnelIsPickedWithThePasswordOnly) {
  const auto refused = rubicon({"knx", "keyring", file, "--server", "1.1.0"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.output, "");
  EXPECT_THAT(refused.errors, HasSubstr("needs the password of the keyring: --password-file"));
  EXPECT_THAT(rubicon({"knx", "keyring", file, "--server", "nonsense"}).errors, HasSubstr("nonsense"));
}

TEST_F(KnxKeyring, ABackboneWithoutAKeyHasNoSecrets) {
  auto root = support::keyring_root("Hall");
  root.add(KeyringElement{"Backbone"}.text("MulticastAddress", "224.0.23.12"));
  const auto path = folder.write("keyless.knxkeys", support::write_keyring(root, kRingPassword));
  const auto shown = rubicon({"knx", "keyring", path});
  EXPECT_EQ(shown.code, 0) << shown.errors;
  EXPECT_THAT(shown.output, HasSubstr("backbone   224.0.23.12, latency 2000 ms; secrets: none\n"));
  EXPECT_EQ(lines_of(rubicon({"--json", "knx", "keyring", path})).at(0)["backbone"]["key"], false);
}

TEST_F(KnxKeyring, WhatIsNoKeyringIsRefusedWithItsLine) {
  const auto refused = rubicon({"knx", "keyring", folder.write("bad.knxkeys", "<a>\n<b/></a>")});
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.errors, HasSubstr("bad.knxkeys: line 1: root element 'a', expected Keyring"));
  EXPECT_EQ(rubicon({"knx", "keyring", folder.file("none.knxkeys")}).code, 1);
}

}  // namespace
}  // namespace rubicon::cli
