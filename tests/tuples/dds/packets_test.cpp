#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <set>

#include "base/bytes.h"
#include "tuples/component.h"
#include "tuples/dds/dds_test_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples {
namespace {

using namespace std::chrono_literals;

/// The first 12 bytes of the GUIDs of a participant and of all its endpoints (DDSI-RTPS 2.5, 8.2.4.1).
using GuidPrefix = std::array<std::uint8_t, 12>;

constexpr GuidPrefix kNobody{1, 0x10, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6};
constexpr int kProcesses = 8;  ///< that listen on this host at most

void append(Bytes& out, std::initializer_list<std::uint8_t> bytes) {
  out.insert(out.end(), bytes);
}

/// What follows the header of a DATA submessage (DDSI-RTPS 2.5, 9.4.5.4): the content of a sample, its key alone, or
/// neither.
enum class Payload : std::uint8_t { kData = 0x04, kKey = 0x08, kNone = 0 };

/// A sample of a built-in writer (DDSI-RTPS 2.5, table 9.2; DDS Security 1.1, table 20; DDS-XTypes 1.3, table 61) in
/// the name of a participant: the first bytes that a GUID as its key, or a text of CDR, would have.
Bytes sample_of(const GuidPrefix& participant, std::uint32_t writer, Payload payload, std::uint8_t number) {
  Bytes data;
  append(data, {0, 0, 16, 0, 0, 0, 0, 0});  // to whom it concerns
  for (int shift = 24; shift >= 0; shift -= 8) data.push_back(static_cast<std::uint8_t>(writer >> shift));
  append(data, {0, 0, 0, 0, number, 0, 0, 0});
  if (payload == Payload::kNone) append(data, {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0});  // disposed and unregistered
  if (payload != Payload::kNone) {
    const auto is_list = (writer & 0xffU) == 0xc2;
    append(data, {0, static_cast<std::uint8_t>(is_list ? 3 : 1), 0, 0});  // PL_CDR_LE, CDR_LE
    if (is_list) append(data, {0x50, 0, 16, 0});
    data.insert(data.end(), participant.begin(), participant.end());
    append(data, {0, 0, 1, 0xc1, 1, 0, 0, 0});
    append(data, {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  }
  Bytes packet{'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  packet.insert(packet.end(), participant.begin(), participant.end());
  const auto flags = payload == Payload::kNone ? 0x03 : 0x01 | static_cast<int>(payload);  // little endian; inline QoS
  append(packet, {0x15, static_cast<std::uint8_t>(flags), static_cast<std::uint8_t>(data.size()), 0});
  packet.insert(packet.end(), data.begin(), data.end());
  return packet;
}

constexpr std::uint32_t kBuiltInWriters[] = {
    0x000100c2, 0x000002c2, 0x000003c2, 0x000004c2, 0x000200c2, 0x000300c3, 0x000301c3,  // discovery, liveliness, types
    0xff0101c2, 0xff0003c2, 0xff0004c2, 0xff0200c2, 0x000201c3, 0xff0202c3, 0x000201c2, 0xff0202c2,  // with security
};

/// An island (1) and a robot (70000) that somebody sends packets to.
struct Packets : testing::Test, TwoComponentsOf<dds::DdsTestEcology> {
  Packets() : socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    participant = dds::Entity(dds_create_participant(ecology.options().domain, nullptr, nullptr));
  }
  ~Packets() override { ::close(socket); }

  template <class Done>
  bool until(Done done) {
    for (int i = 0; i < 1000 && !done(); ++i) time.run_for(10ms);
    return done();
  }
  /// As headers show them, also one of nobody.
  std::set<GuidPrefix> names() const {
    std::set<GuidPrefix> all{kNobody};
    for (const auto& one : dds::participants_in_domain(participant.get())) {
      GuidPrefix prefix{};
      std::copy_n(one.begin(), prefix.size(), prefix.begin());
      all.insert(prefix);
    }
    return all;
  }
  void send(const Bytes& packet) const {
    for (unsigned index = 0; index < kProcesses; ++index) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(static_cast<std::uint16_t>(dds::port_of(ecology.options().domain, index)));
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      ::sendto(socket, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }
  bool meet(Component& one, Component& other) {
    return until([&] { return !one.space.peers().empty() && !other.space.peers().empty(); });
  }

  int socket;
  dds::Entity participant;
};

/// Whoever says that a participant is gone is believed by DDS; a component that comes sees those who are there.
TEST_F(Packets, OfAStrangerInAnyNameWithOrWithoutDataEndNoProcess) {
  ASSERT_TRUE(meet(*island, *robot));
  const auto all = names();
  ASSERT_GE(all.size(), 4U) << "both components, the one of this test, and nobody";
  std::uint8_t number = 0;
  for (const auto writer : kBuiltInWriters) {
    for (const auto payload : {Payload::kData, Payload::kKey, Payload::kNone}) {
      for (const auto& name : all) {
        for (int i = 0; i < 3; ++i) send(sample_of(name, writer, payload, ++number));
      }
      time.run_for(1ms);
    }
  }
  Component newcomer(ecology, time, 70001);
  EXPECT_TRUE(until([&] { return newcomer.space.peers().size() == 2; })) << newcomer.space.peers().size();
}

TEST_F(Packets, ThatArePartsOfOthersOrHaveChangedBytesEndNoProcess) {
  ASSERT_TRUE(meet(*island, *robot));
  std::uint32_t dice = 1;
  const auto next = [&dice] { return dice = dice * 1'664'525U + 1'013'904'223U; };
  for (const auto writer : kBuiltInWriters) {
    for (const auto& name : names()) {
      for (int i = 0; i < 40; ++i) {
        auto packet = sample_of(name, writer, i % 2 == 0 ? Payload::kData : Payload::kKey, 7);
        for (int changes = 0; changes < 3; ++changes)
          packet[20 + (next() >> 8U) % (packet.size() - 20)] = static_cast<std::uint8_t>(next() >> 8U);
        if (i % 5 == 0) packet.resize(20 + (next() >> 8U) % (packet.size() - 20));
        send(packet);
      }
    }
    time.run_for(1ms);
  }
  Component newcomer(ecology, time, 70001);
  EXPECT_TRUE(until([&] { return newcomer.space.peers().size() == 2; })) << newcomer.space.peers().size();
}

}  // namespace
}  // namespace rubicon::tuples
