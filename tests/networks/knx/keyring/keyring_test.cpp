#include "networks/knx/keyring/keyring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "model/findings.h"
#include "support/keyring_writer.h"

namespace rubicon::networks::knx::keyring {
namespace {

using namespace std::chrono_literals;
using support::keyring_root;
using support::KeyringElement;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using wire::GroupAddress;
using wire::IndividualAddress;

constexpr const char* kPassword = "ring word";
constexpr const char* kKey1 = "000102030405060708090a0b0c0d0e0f";
constexpr const char* kKey2 = "303132333435363738393a3b3c3d3e3f";

IndividualAddress device(const char* text) {
  return wire::parse_individual(text).value();
}
constexpr GroupAddress k127{0x0a07}, k201{0x1001};

secure::Secret secret(const std::string& text) {
  return secure::Secret::of_text(text);
}

KeyringElement interface(const char* address, const char* host, const char* user, const char* password) {
  KeyringElement out{"Interface"};
  out.text("Type", "Tunneling").text("IndividualAddress", address).text("Host", host);
  if (*user != '\0') out.text("UserID", user);
  if (*password != '\0') out.password("Password", password);
  return out;
}
KeyringElement group(const char* number, const char* senders) {
  return KeyringElement{"Group"}.text("Address", number).text("Senders", senders);
}
KeyringElement group_key(const char* number, const char* key) {
  return KeyringElement{"Group"}.text("Address", number).key("Key", key);
}

/// Two servers; users are not contiguous.
KeyringElement house() {
  auto root = keyring_root();
  root.add(
      KeyringElement{"Backbone"}.text("MulticastAddress", "224.0.23.77").text("Latency", "1500").key("Key", kKey1));
  root.add(interface("1.1.10", "1.1.0", "6", "six")
               .password("Authentication", "device one")
               .add(group("2567", "1.1.11 1.1.30")));
  root.add(interface("1.1.11", "1.1.0", "3", "three").add(group("2567", "1.1.10 1.1.30")));
  root.add(interface("1.1.12", "1.1.0", "9", "nine"));
  root.add(interface("1.1.13", "1.1.0", "", "").password("Authentication", "device one"));
  root.add(interface("2.1.10", "2.1.0", "2", "two"));
  root.add(KeyringElement{"Interface"}.text("Type", "USB").text("IndividualAddress", "1.1.40"));
  root.add(KeyringElement{"GroupAddresses"}.add(group_key("2567", kKey2)).add(group_key("4097", kKey1)));
  root.add(
      KeyringElement{"Devices"}
          .add(KeyringElement{"Device"}.text("IndividualAddress", "1.1.0").password("Authentication", "device two"))
          .add(KeyringElement{"Device"}.text("IndividualAddress", "1.1.30").text("SequenceNumber", "4294967297")));
  return root;
}

Result<Keyring> read(const KeyringElement& root, const std::string& password = kPassword) {
  const auto file = parse_keyring(support::write_keyring(root, kPassword));
  if (!file) return fail(file.error());
  return Keyring::open(*file, secret(password));
}

// Signature and password.

TEST(Keyring, AWrongPasswordAndAChangedFileHaveDifferentErrors) {
  const auto text = support::write_keyring(house(), kPassword);
  auto changed = text;
  changed.replace(changed.find("1500"), 4, "1501");
  const auto wrong = Keyring::open(*parse_keyring(text), secret("another"));
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, ErrorCode::kRefused);
  EXPECT_EQ(wrong.error().text, "the password of the keyring is wrong");
  EXPECT_EQ(wrong.error().finding, model::findings::kKeyringPassword);
  const auto tampered = Keyring::open(*parse_keyring(changed), secret(kPassword));
  ASSERT_FALSE(tampered);
  EXPECT_EQ(tampered.error().code, ErrorCode::kInvalid);
  EXPECT_EQ(tampered.error().finding, model::findings::kKeyringChanged);
  EXPECT_THAT(tampered.error().text, HasSubstr("was changed after ETS exported it"));
  EXPECT_EQ(Keyring::open(*parse_keyring(changed), secret("another")).error().text, wrong.error().text);
  EXPECT_TRUE(Keyring::open(*parse_keyring(text), secret(kPassword)));
}

/// Two long secrets, as those of a small house.
KeyringElement two_secrets() {
  auto root = keyring_root();
  root.add(interface("1.1.10", "1.1.0", "2", "the password of the tunnel")
               .password("Authentication", "the code of the interface"));
  return root;
}

TEST(Keyring, OneChangedSecretOfTwoIsAChangedFile) {
  auto text = support::write_keyring(two_secrets(), kPassword);
  auto& letter = text[text.find(" Password=\"") + 15];
  letter = letter == 'A' ? 'B' : 'A';
  const auto changed = Keyring::open(*parse_keyring(text), secret(kPassword));
  ASSERT_FALSE(changed);
  EXPECT_THAT(changed.error().text, HasSubstr("was changed after ETS exported it"));
}

/// It is part of the encryption: the first block of each password becomes garbage.
TEST(Keyring, AChangedTimeOfCreationIsAChangedFile) {
  auto text = support::write_keyring(two_secrets(), kPassword);
  text.replace(text.find("T23:50:00"), 9, "T23:50:01");
  const auto changed = Keyring::open(*parse_keyring(text), secret(kPassword));
  ASSERT_FALSE(changed);
  EXPECT_EQ(changed.error().code, ErrorCode::kInvalid);
  EXPECT_THAT(changed.error().text, HasSubstr("was changed after ETS exported it"));
}

TEST(Keyring, AWrongPasswordIsNeverCalledAChangedFile) {
  for (const auto& root : {two_secrets(), house()}) {
    const auto file = parse_keyring(support::write_keyring(root, kPassword)).value();
    for (unsigned number = 0; number < 2000; ++number) {
      const std::string text = "another key " + std::to_string(1000 + number);
      const auto key = secure::Key::from(base::as_bytes(text)).value();
      const auto wrong = Keyring::open(file, Cipher::of_key(key, file.created).value());
      ASSERT_FALSE(wrong);
      EXPECT_EQ(wrong.error().text, "the password of the keyring is wrong") << text;
    }
  }
}

/// As ETS 6 exports a project whose backbone is not secured.
TEST(Keyring, WithoutABackboneKeyTheGroupKeysAreRead) {
  auto root = keyring_root();
  root.add(KeyringElement{"Backbone"}.text("MulticastAddress", "224.0.23.12"));
  root.add(KeyringElement{"GroupAddresses"}.add(group_key("2567", kKey2)));
  const auto keyring = read(root);
  ASSERT_TRUE(keyring) << keyring.error().text;
  EXPECT_FALSE(keyring->routing());
  EXPECT_EQ(keyring->groups().groups.count(k127), 1U);
}

TEST(Keyring, WithKeysOnlyBothReasonsAreNamed) {
  auto root = keyring_root();
  root.add(KeyringElement{"GroupAddresses"}.add(group_key("2567", kKey2)));
  EXPECT_TRUE(read(root));
  const auto either = read(root, "another");
  ASSERT_FALSE(either);
  EXPECT_THAT(either.error().text, AllOf(HasSubstr("password of the keyring is wrong, or"), HasSubstr("was changed")));
}

TEST(Keyring, EachChangeOfAValueIsNoticed) {
  const auto text = support::write_keyring(house(), kPassword);
  const auto cipher = Cipher::make(secret(kPassword), "2026-11-20T23:50:00").value();
  ASSERT_TRUE(Keyring::open(*parse_keyring(text), cipher));
  for (const auto* value : {"House", "224.0.23.77", "1.1.10", "2567", "1.1.30", "4294967297", "USB", "\"6\""}) {
    auto changed = text;
    auto& digit = changed[changed.find(value) + std::string(value).size() - 2];
    digit = digit == '1' ? '2' : '1';
    const auto file = parse_keyring(changed);
    ASSERT_TRUE(file) << value << ": " << file.error().text;
    EXPECT_FALSE(Keyring::open(*file, cipher)) << value;
  }
}

TEST(Keyring, ErrorsHoldNoPassword) {
  const auto wrong = read(house(), "a wrong secret");
  EXPECT_THAT(wrong.error().text, Not(HasSubstr("a wrong secret")));
  const auto keyring = read(house()).value();
  for (const auto* address : {"9.9.9", "1.1.13"}) {
    const auto none = keyring.tunnel({device(address)});
    for (const auto* word : {"six", "three", "nine", "device"})
      EXPECT_THAT(none.error().text, Not(HasSubstr(word))) << address;
  }
}

// Tunnels.

TEST(Keyring, TheWantedTunnelIsPicked) {
  const auto keyring = read(house()).value();
  const auto access = keyring.tunnel({device("1.1.11")}).value();
  EXPECT_EQ(access.user, 3);
  EXPECT_EQ(access.password.text(), "three");
  EXPECT_EQ(access.host, device("1.1.0"));
  EXPECT_EQ(access.authentication->text(), "device two") << "of the device, as the interface has none";
  EXPECT_EQ(keyring.tunnel({device("1.1.10")})->authentication->text(), "device one");
  EXPECT_FALSE(keyring.tunnel({device("2.1.10")})->authentication);
}

TEST(Keyring, AMissingTunnelAndAMissingUserAreNamed) {
  const auto keyring = read(house()).value();
  const auto none = keyring.tunnel({device("1.1.99")}).error();
  EXPECT_EQ(none.code, ErrorCode::kNotFound);
  EXPECT_EQ(none.text,
            "the keyring has no tunnel 1.1.99, only: 1.1.10, 1.1.11, 1.1.12 (interface 1.1.0); 2.1.10 (interface "
            "2.1.0)");
  const auto no_user = keyring.tunnel({device("1.1.13")}).error();
  EXPECT_EQ(no_user.code, ErrorCode::kNotFound);
  EXPECT_EQ(no_user.finding, model::findings::kKeyringNoUser);
  EXPECT_THAT(no_user.text, HasSubstr("no user and password for the tunnel 1.1.13"));
  EXPECT_THAT(keyring.tunnel({device("1.1.40")}).error().text, HasSubstr("no tunnel 1.1.40")) << "USB";
}

TEST(Keyring, OfAServerTheFirstFreeUserIsPicked) {
  const auto keyring = read(house()).value();
  std::vector<IndividualAddress> taken;
  const auto pick = [&] { return keyring.tunnel({{}, device("1.1.0"), taken}); };
  for (const int user : {3, 6, 9}) {
    const auto access = pick();
    ASSERT_TRUE(access) << access.error().text;
    EXPECT_EQ(access->user, user);
    taken.push_back(access->address);
  }
  const auto none = pick();
  EXPECT_EQ(none.error().code, ErrorCode::kBusy);
  EXPECT_EQ(none.error().finding, model::findings::kKeyringTunnelsInUse);
  EXPECT_EQ(keyring.tunnel({{}, device("2.1.0")})->user, 2);
  EXPECT_THAT(keyring.tunnel({{}, device("3.1.0")}).error().text, HasSubstr("no tunnel of the interface 3.1.0"));
}

TEST(Keyring, WithoutAServerItsOnlyServerIsMeant) {
  EXPECT_THAT(read(house())->tunnel({}).error().text, HasSubstr("several interfaces, name one"));
  auto root = keyring_root();
  root.add(interface("1.1.10", "1.1.0", "6", "six"));
  EXPECT_EQ(read(root)->tunnel({})->user, 6);
  EXPECT_THAT(read(keyring_root())->tunnel({}).error().text, HasSubstr("no tunnel with a user and a password"));
}

TEST(Keyring, SessionKeysAreThoseOfThePasswords) {
  auto root = keyring_root();
  root.add(interface("1.1.10", "1.1.0", "2", "user2pw").password("Authentication", "trustme"));
  const auto keys = read(root)->tunnel({})->session_keys().value();
  EXPECT_EQ(keys.user, 2);
  EXPECT_EQ(base::to_hex(keys.user_key.key.view()), "43e24ee1095ee6e9483baa42598b4aba");
  EXPECT_EQ(base::to_hex(keys.device_code->key.view()), "e158e4012047bd6cc41aafbc5c04c1fc");
}

TEST(Keyring, RoutingHasKeyLatencyAndGroup) {
  const auto keyring = read(house()).value();
  ASSERT_TRUE(keyring.routing());
  EXPECT_EQ(keyring.routing()->multicast, "224.0.23.77");
  EXPECT_EQ(keyring.routing()->keys.latency, 1500ms);
  EXPECT_EQ(base::to_hex(keyring.routing()->keys.backbone.view()), kKey1);
  EXPECT_FALSE(read(keyring_root())->routing());
}

// Groups.

TEST(Keyring, SendersOfAGroupAreThoseOfTheOwnInterface) {
  const auto groups = read(house())->groups();
  ASSERT_EQ(groups.groups.size(), 2U);
  const auto& linked = groups.groups.at(k127);
  EXPECT_EQ(base::to_hex(linked.key->view()), kKey2);
  EXPECT_THAT(linked.senders_to(device("1.1.10")), ElementsAre(device("1.1.11"), device("1.1.30")));
  EXPECT_TRUE(linked.may_send_from(device("1.1.10")));
  const auto& unknown = groups.groups.at(k201);
  EXPECT_THAT(unknown.senders, IsEmpty());
  EXPECT_TRUE(unknown.may_send_from(device("1.1.10"))) << "no interface knows it";
  EXPECT_EQ(groups.sequences.at(device("1.1.30")), 4294967297U);
}

TEST(Keyring, OfAnAddressWithoutALinkTheSendersAreThoseOfAllInterfaces) {
  const auto keyring = read(house()).value();
  const auto group = keyring.groups().groups.at(k127);
  EXPECT_THAT(group.senders_to(device("1.1.12")), ElementsAre(device("1.1.10"), device("1.1.11"), device("1.1.30")));
  EXPECT_FALSE(group.may_send_from(device("1.1.12"))) << "nothing would accept it";
  EXPECT_TRUE(group.may_send_from(device("1.1.30"))) << "the interfaces list it as a sender";
  EXPECT_FALSE(group.may_send_from({})) << "an interface without an address is that of no line";
}

// Whatever is written is read.

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  unsigned below(unsigned limit) { return std::uniform_int_distribution<unsigned>(0, limit - 1)(engine); }
  std::string hex() {
    std::string out;
    for (int i = 0; i < 32; ++i) out += "0123456789abcdef"[below(16)];
    return out;
  }
  std::string text() {
    const std::vector<std::string> letters{"a", "Z", "9", "ä", "€", "&", "<", "\"", " ", "§", "%", "'", "\n"};
    std::string out;
    for (auto left = 1 + below(40); left > 0; --left) out += letters[below(static_cast<unsigned>(letters.size()))];
    return out;
  }
  std::mt19937 engine;
};

TEST(Keyring, WhatIsWrittenIsReadBack) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const auto password = random.text();
    auto root = keyring_root(random.text());
    std::vector<std::pair<std::string, std::string>> passwords;
    std::vector<std::string> keys;
    const auto tunnels = random.below(8);
    for (unsigned i = 0; i < tunnels; ++i) {
      const auto address = "1.1." + std::to_string(10 + i);
      passwords.emplace_back(address, random.text());
      root.add(interface(address.c_str(), "1.1.0", std::to_string(2 + i).c_str(), passwords.back().second.c_str()));
    }
    KeyringElement all{"GroupAddresses"};
    for (auto left = random.below(20); left > 0; --left) {
      keys.push_back(random.hex());
      all.add(group_key(std::to_string(keys.size()).c_str(), keys.back().c_str()));
    }
    root.add(all).add(KeyringElement{"Unknown"}.text("Long", std::string(200 + random.below(300), 'x')));
    const auto file = parse_keyring(support::write_keyring(root, password, seed));
    ASSERT_TRUE(file) << file.error().text;
    const auto keyring = Keyring::open(*file, secret(password));
    ASSERT_TRUE(keyring) << seed << ": " << keyring.error().text;
    for (const auto& [address, word] : passwords)
      EXPECT_EQ(keyring->tunnel({device(address.c_str())})->password.text(), word) << seed;
    const auto groups = keyring->groups();
    ASSERT_EQ(groups.groups.size(), keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const auto& entry = groups.groups.at(GroupAddress(static_cast<std::uint16_t>(i + 1)));
      EXPECT_EQ(base::to_hex(entry.key->view()), keys[i]) << seed;
    }
  }
}

}  // namespace
}  // namespace rubicon::networks::knx::keyring
