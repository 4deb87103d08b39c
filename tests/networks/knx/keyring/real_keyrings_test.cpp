#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "networks/knx/keyring/keyring.h"

namespace rubicon::networks::knx::keyring {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using wire::IndividualAddress;

const std::string kFolder = RUBICON_SOURCE_DIR "/../shared/data/";

std::string content_of(const std::string& path) {
  std::ifstream file(kFolder + path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Element and attributes, in the order of the file.
using Elements = std::vector<std::pair<std::string, json>>;

/// The decrypted elements of a keyring as expected.tsv writes them.
class Listing {
 public:
  Listing(const KeyringFile& file, const Cipher& cipher) : cipher_(cipher) {
    add("Keyring", {{"Project", file.project}, {"CreatedBy", file.created_by}, {"Created", file.created}});
    if (file.backbone) {
      json backbone{{"MulticastAddress", file.backbone->multicast},
                    {"Latency", std::to_string(file.backbone->latency / std::chrono::milliseconds(1))}};
      key(backbone, "Key", file.backbone->key);
      add("Backbone", backbone);
    }
    for (const auto& one : file.interfaces) interface(one);
    for (const auto& one : file.group_keys) {
      json group{{"Address", std::to_string(number(one.address))}};
      key(group, "Key", one.key);
      add("Group", group);
    }
    for (const auto& one : file.devices) device(one);
  }
  Elements elements;

 private:
  void add(const std::string& name, json attributes) { elements.emplace_back(name, std::move(attributes)); }
  void key(json& into, const char* name, const Bytes& encrypted) {
    if (!encrypted.empty()) into[name] = base::to_hex(cipher_.key(encrypted).value().view());
  }
  void password(json& into, const char* name, const Bytes& encrypted) {
    if (!encrypted.empty()) into[name] = std::string(cipher_.password(encrypted).value().text());
  }
  static void address(json& into, const char* name, IndividualAddress address) {
    if (number(address) != 0) into[name] = to_string(address);
  }
  void interface(const KeyringFile::Interface& one) {
    json out{{"Type", one.type}};
    address(out, "IndividualAddress", one.address);
    address(out, "Host", one.host);
    if (one.user) out["UserID"] = std::to_string(*one.user);
    password(out, "Password", one.password);
    password(out, "Authentication", one.authentication);
    add("Interface", out);
    for (const auto& group : one.groups) {
      std::string senders;
      for (const auto sender : group.senders) senders += (senders.empty() ? "" : " ") + to_string(sender);
      add("Group", {{"Address", std::to_string(number(group.address))}, {"Senders", senders}});
    }
  }
  void device(const KeyringFile::Device& one) {
    json out = json::object();
    address(out, "IndividualAddress", one.address);
    key(out, "ToolKey", one.tool_key);
    password(out, "ManagementPassword", one.management_password);
    password(out, "Authentication", one.authentication);
    if (one.sequence) out["SequenceNumber"] = std::to_string(*one.sequence);
    add("Device", out);
  }

  const Cipher& cipher_;
};

struct Expected {
  std::string password;
  Elements elements;
};

std::map<std::string, Expected> expected_files() {
  std::map<std::string, Expected> all;
  std::ifstream table(kFolder + "knx-secure/keyrings/expected.tsv");
  std::string line;
  std::getline(table, line);
  while (std::getline(table, line)) {
    std::istringstream cells(line);
    std::string file, password, signature, element, attributes;
    for (auto* cell : {&file, &password, &signature, &element, &attributes}) std::getline(cells, *cell, '\t');
    EXPECT_EQ(signature, "good");
    all[file].password = password;
    if (element != "GroupAddresses" && element != "Devices")
      all[file].elements.emplace_back(element, json::parse(attributes));
  }
  return all;
}

TEST(RealKeyrings, EveryElementIsDecryptedAsExpected) {
  const auto files = expected_files();
  if (files.empty()) GTEST_SKIP() << "no ../shared/data/knx-secure/keyrings beside the source tree";
  EXPECT_EQ(files.size(), 4U);
  for (const auto& [name, expected] : files) {
    const auto file = parse_keyring(content_of("knx-secure/keyrings/" + name));
    ASSERT_TRUE(file) << name << ": " << file.error().text;
    const auto cipher = Cipher::make(secure::Secret::of_text(expected.password), file->created).value();
    EXPECT_TRUE(cipher.signed_by_this(*file).value()) << name;
    EXPECT_EQ(Listing(*file, cipher).elements, expected.elements) << name;
    EXPECT_TRUE(Keyring::open(*file, cipher)) << name;
    const auto wrong = Keyring::open(*file, secure::Secret::of_text("wrong"));
    ASSERT_FALSE(wrong) << name;
    EXPECT_THAT(wrong.error().text, HasSubstr("password of the keyring is wrong")) << name;
    EXPECT_EQ(wrong.error().text.find("changed") != std::string::npos, name == "DataSecure_usb.knxkeys")
        << "only keys there: both reasons";
  }
}

TEST(RealKeyrings, ChangedOnesAreRefusedForThat) {
  std::size_t checked = 0;
  for (const auto& [name, password] : {std::pair<std::string, std::string>{"knx/rig-tampered.knxkeys", "rigpass"},
                                       {"knx-secure/give-tampered.knxkeys", "give-Pass9"},
                                       {"knx-secure/keyrings/give-tampered.knxkeys", "give-Pass9"}}) {
    const auto text = content_of(name);
    if (text.empty()) continue;
    const auto changed = Keyring::open(*parse_keyring(text), secure::Secret::of_text(password));
    ASSERT_FALSE(changed) << name;
    EXPECT_THAT(changed.error().text, HasSubstr("was changed after ETS exported it")) << name;
    ++checked;
  }
  if (checked == 0) GTEST_SKIP() << "no ../shared/data/knx-secure beside the source tree";
}

TEST(RealKeyrings, TheKeyringOfTheRigGivesItsKeys) {
  const auto text = content_of("knx/rig.knxkeys");
  if (text.empty()) GTEST_SKIP() << "no ../shared/data/knx/rig.knxkeys beside the source tree";
  const auto keyring = Keyring::open(*parse_keyring(text), secure::Secret::of_text("rigpass")).value();
  EXPECT_EQ(base::to_hex(keyring.routing()->keys.backbone.view()), "000102030405060708090a0b0c0d0e0f");
  const auto access = keyring.tunnel({IndividualAddress(0x710a)}).value();
  EXPECT_EQ(access.user, 2);
  EXPECT_EQ(access.password.text(), "user2pw");
  EXPECT_EQ(access.authentication->text(), "trustme");
  const auto groups = keyring.groups();
  EXPECT_EQ(base::to_hex(groups.groups.at(wire::GroupAddress(2567)).key->view()), "303132333435363738393a3b3c3d3e3f");
}

}  // namespace
}  // namespace rubicon::networks::knx::keyring
