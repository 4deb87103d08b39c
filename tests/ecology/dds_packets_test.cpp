#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/if_ether.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <sstream>

#include "base/bytes.h"
#include "support/conversation.h"
#include "support/folder.h"
#include "support/private_network.h"
#include "support/programs.h"
#include "tuples/dds/dds_options.h"

namespace rubicon::ecology {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;
using support::ask;
using support::Process;
using GuidStart = std::array<std::uint8_t, 12>;  ///< of a participant, in the header of each of its packets
using Dice = std::mt19937;

constexpr std::size_t kHeader = 20;  ///< of a message of RTPS (DDSI-RTPS 2.5, 9.4.4)
constexpr unsigned kListeners = 4;   ///< processes that are sent to
constexpr int kPacketsAtOnce = 20;   ///< fit into what a socket keeps
constexpr GuidStart kNobody{1, 0x10, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6};
/// With receive buffers of Cyclone's own size it is four times as much after a minute.
constexpr long kMaxKilobytes = 16L * 1024;

/// What a DATA submessage has behind its header (DDSI-RTPS 2.5, 9.4.5.4).
enum class Content : std::uint8_t { kData = 0x04, kKey = 0x08, kNone = 0 };

/// DDSI-RTPS 2.5, table 9.2; DDS-XTypes 1.3, table 61; DDS Security 1.1, table 20.
constexpr std::uint32_t kDiscoveryWriters[] = {
    0x000100c2, 0x000002c2, 0x000003c2, 0x000004c2, 0x000200c2, 0x000300c3, 0x000301c3,  // participants to types
    0xff0101c2, 0xff0003c2, 0xff0004c2, 0xff0200c2, 0x000201c3, 0xff0202c3, 0x000201c2, 0xff0202c2,  // with security
};

std::uint32_t word_at(const Bytes& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | bytes[at + i];
  return word;
}

unsigned roll(Dice& dice, std::size_t sides) {
  return sides == 0 ? 0 : static_cast<unsigned>(dice() % sides);
}

/// The packets of DDS on loopback, as everybody there may hear them.
class Overheard {
 public:
  Overheard() : socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP))) {
    const int size = 4 << 20;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &size, sizeof size);
  }
  ~Overheard() { ::close(socket_); }
  Overheard(const Overheard&) = delete;
  Overheard& operator=(const Overheard&) = delete;

  void listen() {
    std::array<std::uint8_t, 65536> buffer{};
    for (ssize_t size = 0; (size = ::recv(socket_, buffer.data(), buffer.size(), 0)) > 0;) {
      const std::size_t start = 4UL * (buffer[0] & 0xfU) + 8;  // headers of IP and UDP
      if (static_cast<std::size_t>(size) < start + kHeader || buffer[start] != 'R' || buffer[start + 3] != 'S')
        continue;
      note(Bytes(buffer.begin() + static_cast<long>(start), buffer.begin() + size));
    }
  }
  /// Of those who speak.
  const std::vector<GuidStart>& names() const { return names_; }
  /// One that this writer sent, or any other one; where it has the name of a participant now and then that of another.
  Bytes content(std::uint32_t writer, const GuidStart& name, Dice& dice) const {
    auto found = contents_.find(writer);
    if (found == contents_.end() || roll(dice, 8) == 0)
      found = std::next(contents_.begin(), roll(dice, contents_.size()));
    auto bytes = found->second[roll(dice, found->second.size())];
    if (roll(dice, 3) == 0) return bytes;
    for (const auto& one : names_) {
      for (auto at = bytes.begin(); (at = std::search(at, bytes.end(), one.begin(), one.end())) != bytes.end();)
        at = std::copy(name.begin(), name.end(), at);
    }
    return bytes;
  }

 private:
  /// Without descriptions of types: Cyclone DDS 0.10.2 ends its process where one is of a kind that it does not expect
  /// (the check of its type information; 0xf3 in place of 0xf2). They get a number that nobody knows.
  static Bytes without_types(Bytes content) {
    constexpr std::uint8_t kTypes[] = {0x75, 0};
    for (std::size_t at = 4; at + 4 <= content.size();) {
      if (std::equal(std::begin(kTypes), std::end(kTypes), content.begin() + static_cast<long>(at))) content[at] = 0x7a;
      at += 4 + static_cast<std::size_t>(content[at + 2] | content[at + 3] << 8);
    }
    return content;
  }
  void note(const Bytes& packet) {
    GuidStart name{};
    std::copy_n(packet.begin() + 8, name.size(), name.begin());
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) names_.push_back(name);
    for (auto at = kHeader; at + 4 <= packet.size();) {
      const auto size = static_cast<std::size_t>(packet[at + 2] | packet[at + 3] << 8);
      const auto end = std::min(size == 0 ? packet.size() : at + 4 + size, packet.size());
      const bool is_data = packet[at] == 0x15 && (packet[at + 1] & 0x07) == 0x05;  // without inline QoS
      if (is_data && at + 24 < end) {
        auto& same = contents_[word_at(packet, at + 12)];
        if (same.size() < 64)
          same.push_back(without_types(
              Bytes(packet.begin() + static_cast<long>(at) + 24, packet.begin() + static_cast<long>(end))));
      }
      at = end;
    }
  }

  int socket_;
  std::vector<GuidStart> names_;
  std::map<std::uint32_t, std::vector<Bytes>> contents_;
};

/// A sample of a built-in writer in the name of a participant.
Bytes sample_of(const GuidStart& name, std::uint32_t writer, Content content, const Bytes& bytes, std::uint8_t number) {
  Bytes packet{'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  packet.insert(packet.end(), name.begin(), name.end());
  const bool ends = content == Content::kNone || number % 2 == 0;           // says so in its inline QoS
  const auto flags = 0x01 | (ends ? 0x02 : 0) | static_cast<int>(content);  // little endian
  packet.insert(packet.end(), {0x15, static_cast<std::uint8_t>(flags), 0, 0, 0, 0, 16, 0, 0, 0, 0, 0});  // to the end
  for (int shift = 24; shift >= 0; shift -= 8) packet.push_back(static_cast<std::uint8_t>(writer >> shift));
  packet.insert(packet.end(), {0, 0, 0, 0, number, 0, 0, 0});
  if (ends) packet.insert(packet.end(), {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0});  // disposed and unregistered
  if (content != Content::kNone) packet.insert(packet.end(), bytes.begin(), bytes.end());
  return packet;
}

/// Other bytes behind the header, or fewer or more of them.
void mutate(Bytes& packet, Dice& dice) {
  constexpr std::uint8_t kEdges[] = {0, 1, 2, 0x7f, 0x80, 0xfe, 0xff};
  for (auto times = roll(dice, 5); times > 0 && packet.size() > kHeader + 4; --times) {
    const auto at = static_cast<long>(kHeader + roll(dice, packet.size() - kHeader));
    const auto rest = static_cast<unsigned>(packet.end() - packet.begin() - at);
    switch (roll(dice, 8)) {
      case 0: packet.resize(static_cast<std::size_t>(at)); break;
      case 1: packet.insert(packet.begin() + at, 1 + roll(dice, 64), static_cast<std::uint8_t>(dice())); break;
      case 2: packet.erase(packet.begin() + at, packet.begin() + at + 1 + roll(dice, std::min(rest, 32U))); break;
      case 3: std::fill_n(packet.begin() + at, std::min(rest, 4U), kEdges[roll(dice, std::size(kEdges))]); break;
      case 4: packet[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1U << roll(dice, 8)); break;
      case 5: packet[static_cast<std::size_t>(at)] = kEdges[roll(dice, std::size(kEdges))]; break;
      default: packet[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(dice()); break;
    }
  }
}

/// An island and a component that meet by DDS without any protection, and whoever reaches their ports.
class DdsPackets : public testing::Test {
 protected:
  void SetUp() override {
    if (!alone_.entered()) GTEST_SKIP() << alone_.reason();
    std::ofstream(folder_ / "1.yaml")
        << "island: {id: 1, name: home}\ntuples: {interfaces: [lo], host: no}\nnetworks:\n"
        << "  dummy-1: {type: dummy, simulate: {den: {actuators: {switch-1: {}}}}}\n";
    heard_ = std::make_unique<Overheard>();
    island_ = std::make_unique<Process>(
        std::vector<std::string>{support::kDaemon, "run", folder_ / "1.yaml", "--shell", "--log-level", "warning"});
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    meet_a_peer();
    heard_->listen();
    ASSERT_GE(heard_->names().size(), 2U);
  }
  void TearDown() override {
    if (socket_ >= 0) ::close(socket_);
  }

  /// A new one each time: packets in the name of another may make it and the island deaf to each other for good.
  void meet_a_peer() {
    const auto id = std::to_string(70'000 + ++peers_), state = std::string(peers_ % 2 == 0 ? "on" : "off");
    peer_ = std::make_unique<Process>(std::vector<std::string>{RUBICON_BINARY_DIR "/bin/ecology-member", id, "dds"});
    ASSERT_TRUE(answers(*island_, "subscribe " + id + ":a")) << said();
    ASSERT_TRUE(answers(*peer_, "sub all 1:proxy.dummy-1.**")) << said();
    ASSERT_TRUE(answers(*peer_, "set a " + id)) << said();
    EXPECT_TRUE(support::until(*island_, "get " + id + ":a", 60s, [&](const json& tuple) {
      return tuple.value("value", "") == id;
    })) << island_->errors();
    EXPECT_TRUE(answers(*island_, "set proxy.dummy-1.den.actuator.switch-1.command " + state));
    EXPECT_TRUE(support::until(*peer_, "copies", 60s, [&](const json& answer) {
      return answer["copies"].value("1:proxy.dummy-1.den.actuator.switch-1.value", "") == state;
    })) << island_->errors();
  }
  /// How both ended, if they did.
  std::string said() const {
    std::string all;
    for (auto* one : {island_.get(), peer_.get()}) {
      one->close_input();
      all += one->errors() + "exit code " + std::to_string(one->exit_code()) + "\n";
    }
    return all;
  }
  static bool answers(Process& program, const std::string& command) {
    const auto answer = ask(program, command);
    return answer.is_object() && answer.value("ok", false);
  }
  /// Until nothing waits in a socket.
  void drain() const {
    std::array<std::uint8_t, 4096> answer{};
    for (bool empty = false; !empty;) {
      while (::recv(socket_, answer.data(), answer.size(), MSG_DONTWAIT) >= 0) {
      }
      empty = true;
      std::ifstream file("/proc/thread-self/net/udp");
      std::string line, word;
      for (std::getline(file, line); std::getline(file, line);) {
        std::istringstream words(line);
        for (int column = 0; column < 5; ++column) words >> word;  // the last one: waiting to be sent, and to be read
        empty &= word.ends_with(":00000000");
      }
    }
  }
  void send(const Bytes& packet) const {
    for (unsigned i = 0; i < 2 * kListeners; ++i) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(static_cast<std::uint16_t>(tuples::dds::port_of(0, 0) + i));
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }
  /// Of every writer with every content and in every name. False: a program ended.
  bool send_of_every_kind(Dice& dice) {
    auto names = heard_->names();
    names.push_back(kNobody);
    for (const auto writer : kDiscoveryWriters) {
      for (const auto content : {Content::kData, Content::kKey, Content::kNone}) {
        for (const auto& name : names) {
          for (int i = 0; i < kPacketsAtOnce; ++i) {
            auto packet = sample_of(name, writer, content, heard_->content(writer, name, dice), ++number_);
            mutate(packet, dice);
            send(packet);
          }
          drain();
        }
      }
      if (!answers(*island_, "get proxy.dummy-1.den.description") || !answers(*peer_, "set b x")) return false;
    }
    return true;
  }

  support::PrivateNetwork alone_;
  support::Folder folder_;
  std::unique_ptr<Overheard> heard_;
  std::unique_ptr<Process> island_, peer_;
  int socket_ = -1, peers_ = 0;
  std::uint8_t number_ = 0;
};

/// RUBICON_PACKET_SECONDS: for so long, else a few rounds.
TEST_F(DdsPackets, OfAnybodyInAnyNameEndNoIsland) {
  const auto* seconds = std::getenv("RUBICON_PACKET_SECONDS");
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds == nullptr ? 0 : std::stol(seconds));
  Dice dice(4711);
  const auto rounds = [&] {
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(send_of_every_kind(dice)) << said();
  };
  rounds();
  meet_a_peer();
  const auto before = island_->resident_kilobytes();
  int count = 0;
  for (; (count == 0 || std::chrono::steady_clock::now() < end) && !HasFatalFailure(); ++count) rounds();
  if (HasFatalFailure()) return;
  meet_a_peer();
  const auto growth = island_->resident_kilobytes() - before;
  RecordProperty("rounds", count * 3);
  RecordProperty("kilobytes", static_cast<int>(growth));
  EXPECT_LT(growth, kMaxKilobytes);
  island_->write("quit\n");
  EXPECT_EQ(island_->exit_code(), 0) << island_->errors();
}

/// One that comes before its turn is kept until the others come, and so is the buffer where it lies.
TEST_F(DdsPackets, ThatWaitForOthersKeepLittle) {
  Dice dice(4711);
  const Bytes little(64);
  auto much = heard_->content(0x000100c2, kNobody, dice);
  much.resize(60'000);
  const auto before = island_->resident_kilobytes();
  for (std::uint8_t number = 100; number < 228; ++number) {
    for (const auto& name : heard_->names()) send(sample_of(name, 0x000200c2, Content::kData, little, number));
    for (int i = 0; i < 18; ++i) {
      send(sample_of(kNobody, 0x000100c2, Content::kData, much, 1));
      drain();
    }
  }
  meet_a_peer();
  EXPECT_LT(island_->resident_kilobytes() - before, kMaxKilobytes);
}

}  // namespace
}  // namespace rubicon::ecology
