#pragma once

#include <memory>
#include <string>
#include <vector>

#include "networks/knx/bench.h"
#include "networks/knx/secure/group_guard.h"
#include "networks/knx/secure/passwords.h"
#include "networks/knx/wire/cemi.h"
#include "support/keyring_writer.h"

namespace rubicon::networks::knx {

inline constexpr const char* kGroupKey = "303132333435363738393a3b3c3d3e3f";
inline constexpr std::string_view kSecureHouse =
    R"({"via": "tunnel-tcp", "host": "10.0.0.10", "telegrams-per-second": 0,
  "keyring": "house.knxkeys", "keyring-password-file": "house.password", "groups": {
  "1/2/7": {"dpt": "9.001", "name": "Hall temperature"},
  "1/2/8": {"dpt": "9.001", "name": "Garden temperature"},
  "2/0/1": {"dpt": "9.001", "kind": "actuator", "name": "Set point"}}})";

inline secure::Key key_of_user(const char* password) {
  return secure::user_key(secure::Secret::of_text(password))->key;
}

/// Server 1.1.0 with the tunnel 1.1.201 of user 4; 1/2/7 and 2/0/1 are secured, and written by 1.1.30 too.
inline std::string house_keyring(const std::string& password = "ring word", const char* user_password = "four") {
  const auto link = [](const char* number) {
    return support::KeyringElement{"Group"}.text("Address", number).text("Senders", "1.1.30 1.1.201");
  };
  const auto group = [](const char* number) {
    return support::KeyringElement{"Group"}.text("Address", number).key("Key", kGroupKey);
  };
  auto root = support::keyring_root();
  support::KeyringElement tunnel{"Interface"};
  tunnel.text("Type", "Tunneling").text("IndividualAddress", "1.1.201").text("Host", "1.1.0").text("UserID", "4");
  tunnel.password("Password", user_password).password("Authentication", "the device");
  root.add(tunnel.add(link("2567")).add(link("4097")));
  root.add(support::KeyringElement{"GroupAddresses"}.add(group("2567")).add(group("4097")));
  return support::write_keyring(root, password);
}

/// The house of kSecureHouse: a secured interface at 10.0.0.10 and a keyring in the files of the host.
class SecureKnx : public KnxBench {
 protected:
  SecureKnx() {
    host.files.put("house.knxkeys", house_keyring());
    host.files.put("house.password", "ring word\n");
    knx_simulator::SecureOptions secured;
    secured.device_code = secure::device_code(secure::Secret::of_text("the device"))->key;
    secured.users = {{4, key_of_user("four"), 0x11c9}};
    support::KnxServer::Options options;
    options.at = {"10.0.0.10", 3671};
    options.wanted_addresses = true;
    options.secure = std::move(secured);
    secure_server = std::make_unique<support::KnxServer>(host.time, host.net, options);
  }

  /// Another device of the installation: 1.1.30.
  Bytes from_device(std::uint16_t group, Bytes value) {
    wire::Telegram telegram;
    telegram.destination = wire::GroupAddress(group);
    telegram.payload = {std::move(value), false};
    telegram.source = kDevice;
    return device_guard.protect(wire::CemiCode::kDataIndication, telegram, kDevice).value();
  }
  static secure::GroupKeys device_keys() {
    secure::GroupKeys keys;
    const auto key = secure::Key::from(base::from_hex(kGroupKey).value()).value();
    for (const auto group : {0x0a07, 0x1001})
      keys.groups[wire::GroupAddress(static_cast<std::uint16_t>(group))] = {key,
                                                                            {wire::IndividualAddress(0x11c9), kDevice}};
    return keys;
  }
  secure::GroupStorage device_storage() {
    return {[this](std::string_view name, ByteView value) -> Result<void> {
              device_memory[std::string(name)] = Bytes(value.begin(), value.end());
              return {};
            },
            [this](std::string_view name) -> Result<std::optional<Bytes>> {
              const auto found = device_memory.find(std::string(name));
              return found == device_memory.end() ? std::optional<Bytes>() : std::optional(found->second);
            }};
  }
  void command(double value) {
    ASSERT_TRUE(send(model::Actuate{5, point(Kind::kActuator, "temperature"), value}, "2/0/1"));
    host.time.run_for(5s);
  }
  std::vector<model::Outcome> outcomes() const {
    std::vector<model::Outcome> all;
    for (const auto& [device, answer] : host.all<model::Acknowledge>()) all.push_back(answer.outcome);
    return all;
  }
  /// What the bus heard of ours for 2/0/1.
  std::vector<Bytes> heard() const {
    std::vector<Bytes> all;
    for (const auto& one : secure_server->heard())
      if (one.destination == group("2/0/1")) all.push_back(one.tpdu);
    return all;
  }
  static std::uint64_t sequence_of(const Bytes& tpdu) {
    std::uint64_t number = 0;
    for (std::size_t i = 3; i < 9; ++i) number = number << 8U | tpdu.at(i);
    return number;
  }
  std::uint64_t count(const std::string& name) const { return last_state().counters.at(name); }

  static constexpr wire::IndividualAddress kDevice{0x111e};
  std::unique_ptr<support::KnxServer> secure_server;
  std::map<std::string, Bytes> device_memory;
  secure::GroupGuard device_guard{host.time, device_keys(), device_storage(), kDevice, {}};
};

}  // namespace rubicon::networks::knx
