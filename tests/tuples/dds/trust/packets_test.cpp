#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <iterator>

#include "base/bytes.h"
#include "tuples/dds/dds_options.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/shield.h"
#include "tuples/dds/silent_participants.h"
#include "tuples/dds/trust/trusted_members.h"

namespace rubicon::tuples::dds {
namespace {

constexpr int kProcesses = 8;  ///< that listen on this host at most
constexpr int kLocators = 1000;

/// The discovery of an endpoint: who writes, and who reads (DDS Security 1.1, 7.4.7.1; DDSI-RTPS 2.5, table 9.5).
struct Endpoints {
  std::array<std::uint8_t, 4> reader, writer;
};
constexpr Endpoints kSecureDiscovery{{0xff, 0x01, 0x01, 0xc7}, {0xff, 0x01, 0x01, 0xc2}};
constexpr Endpoints kDiscovery{{0x00, 0x01, 0x00, 0xc7}, {0x00, 0x01, 0x00, 0xc2}};

void append(Bytes& out, std::initializer_list<std::uint8_t> bytes) {
  out.insert(out.end(), bytes);
}

/// `status` says that the participant is disposed and unregistered; its GUID is the key
/// (DDSI-RTPS 2.5, 9.6.3.9, 9.6.4).
Bytes end_of(const GuidPrefix& participant, const Endpoints& endpoints) {
  Bytes data;
  append(data, {0, 0, 16, 0});
  data.insert(data.end(), endpoints.reader.begin(), endpoints.reader.end());
  data.insert(data.end(), endpoints.writer.begin(), endpoints.writer.end());
  append(data, {0, 0, 0, 0, 1, 0, 0, 0});                 // number of the sample
  append(data, {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0});  // inline QoS: status info, end of the list
  append(data, {0, 3, 0, 0, 0x50, 0, 16, 0});             // PL_CDR_LE, GUID of the participant
  data.insert(data.end(), participant.begin(), participant.end());
  append(data, {0, 0, 1, 0xc1, 1, 0, 0, 0});
  Bytes packet{'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  append(packet, {1, 0x10, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6});                  // of a sender that nobody knows
  append(packet, {0x15, 0x0b, static_cast<std::uint8_t>(data.size()), 0});  // DATA: little endian, inline QoS, key
  packet.insert(packet.end(), data.begin(), data.end());
  return packet;
}

void append_parameter(Bytes& out, std::uint8_t id, std::initializer_list<std::uint8_t> value) {
  append(out, {id, 0, static_cast<std::uint8_t>(value.size()), 0});
  append(out, value);
}

/// A participant of another GUID prefix announces itself without endpoints for discovery: Cyclone ties it to the sender
/// (DDSI-RTPS 2.5, 8.5.3.2, 9.6.3; tables 9.12 to 9.18).
Bytes dependent_participant(std::string_view tag) {
  Bytes packet{'R', 'T', 'P', 'S', 2, 1, 1, 0x10};
  append(packet, {1, 0x10, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6});
  append(packet, {0x15, 0x05, 0, 0, 0, 0, 16, 0});  // DATA to the end of the packet: little endian, with data
  append(packet, {0, 1, 0, 0xc7, 0, 1, 0, 0xc2, 0, 0, 0, 0, 1, 0, 0, 0});
  append(packet, {0, 3, 0, 0});  // PL_CDR_LE
  append_parameter(packet, 0x15, {2, 1, 0, 0});
  append_parameter(packet, 0x16, {1, 0x10, 0, 0});
  append_parameter(packet, 0x50, {1, 0x10, 7, 7, 7, 7, 7, 7, 7, 7, 7, 7, 0, 0, 1, 0xc1});
  append_parameter(packet, 0x58, {0, 0x0c, 0, 0});  // built-in endpoints: liveliness only
  const auto size = static_cast<std::uint8_t>(tag.size() + 1);
  append(packet, {0x14, 0x40, static_cast<std::uint8_t>(4 + (size + 3) / 4 * 4), 0, size, 0, 0, 0});  // domain tag
  packet.insert(packet.end(), tag.begin(), tag.end());
  packet.insert(packet.end(), static_cast<std::size_t>((size + 3) / 4 * 4) - tag.size(), 0);
  for (int i = 0; i < kLocators; ++i) {
    for (const auto kind : {std::uint8_t{0x31}, std::uint8_t{0x32}}) {  // of the data, of discovery: UDP on IPv4
      append_parameter(packet, kind,
                       {1,
                        0,
                        0,
                        0,
                        0x10,
                        0x27,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        0,
                        127,
                        1,
                        static_cast<std::uint8_t>(i / 250),
                        static_cast<std::uint8_t>(1 + i % 250)});
    }
  }
  append(packet, {1, 0, 0, 0});
  return packet;
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

/// A process without a certificate, which sees who takes part, and sends packets to all of them.
class Stranger {
 public:
  Stranger() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    options_.tag = "trust";
    domain_ = Entity(dds_create_domain(options_.domain, domain_xml(options_).c_str()));
    participant_ = Entity(dds_create_participant(options_.domain, nullptr, nullptr));
  }
  ~Stranger() { ::close(socket_); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;

  /// All but itself, when there are so many (a minute at most).
  std::set<GuidPrefix> others(std::size_t count) const {
    std::set<GuidPrefix> all;
    for (int i = 0; i < 6000 && all.size() <= count; ++i) {
      all = participants_in_domain(participant_.get());
      dds_sleepfor(DDS_MSECS(10));
    }
    return all;
  }
  /// Of the domain: with that of this host.
  std::string tag() const {
    const auto xml = domain_xml(options_);
    const auto begin = xml.find("<Tag>") + 5;
    return xml.substr(begin, xml.find("</Tag>") - begin);
  }
  void send(const Bytes& packet) const {
    for (unsigned index = 0; index < kProcesses; ++index) {
      sockaddr_in to{};
      to.sin_family = AF_INET;
      to.sin_port = htons(static_cast<std::uint16_t>(port_of(options_.domain, index)));
      to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
    }
  }

 private:
  DdsOptions options_;
  int socket_;
  Entity domain_, participant_;
};

TEST(Shield, IsCalledByCyclone) {
  EXPECT_TRUE(Shield::is_first());
}

class Packets : public TrustedMembers {};

TEST_F(Packets, OfAStrangerInAnyNameWithOrWithoutDataEndNoProcess) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  const Stranger stranger;
  auto names = stranger.others(2);
  ASSERT_GE(names.size(), 3U) << "itself too";
  names.insert(GuidPrefix{1, 0x10, 6, 6, 6, 6, 6, 6, 6, 6, 6, 6});
  std::uint8_t number = 0;
  for (const auto writer : kBuiltInWriters) {
    for (const auto payload : {Payload::kData, Payload::kKey, Payload::kNone}) {
      for (const auto& name : names) {
        for (int i = 0; i < 3; ++i) stranger.send(sample_of(name, writer, payload, ++number));
      }
    }
    EXPECT_EQ(ask(*island, "losses"), "0") << "writer " << writer;
    EXPECT_EQ(ask(*tool, "losses"), "0") << "writer " << writer;
  }
  tool->write("send 7 50\n");
  EXPECT_TRUE(until(*tool, "answered 50"));
}

TEST_F(Packets, OfAStrangerEndNoMember) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  island->write("set a 1\n");
  ASSERT_TRUE(until(*tool, "value 7 a 1"));
  const Stranger stranger;
  const auto others = stranger.others(2);
  ASSERT_GE(others.size(), 3U) << "itself too";
  for (int i = 0; i < 20; ++i) {
    for (const auto& one : others) {
      stranger.send(end_of(one, kSecureDiscovery));
      stranger.send(end_of(one, kDiscovery));
    }
  }
  tool->write("send 7 50\n");
  EXPECT_TRUE(until(*tool, "answered 50"));
  EXPECT_EQ(ask(*tool, "replies"), "50 of 50");
  island->write("set a 2\n");
  EXPECT_TRUE(until(*tool, "value 7 a 2"));
  EXPECT_EQ(ask(*tool, "losses"), "0");
  EXPECT_EQ(ask(*island, "losses"), "0");
}

/// Each one would keep some 100 KB.
TEST_F(Packets, OfAStrangerTakeNoMemory) {
  const auto island = home(), tool = desk();
  meet(*island, *tool);
  const Stranger stranger;
  const auto packet = dependent_participant(stranger.tag());
  const auto grow = [&](int count) {
    for (int i = 0; i < count; ++i) {
      stranger.send(packet);
      EXPECT_EQ(ask(*island, "losses"), "0");  // so that it is not lost in a full socket
    }
    return island->resident_kilobytes();
  };
  const auto before = grow(20);
  EXPECT_LT(grow(300) - before, 15'000);
}

TEST_F(Packets, DoNotKeepAMemberThatLeft) {
  const auto island = home();
  auto tool = desk();
  meet(*island, *tool);
  tool.reset();
  EXPECT_TRUE(until(*island, "alone"));
  tool = desk();
  meet(*island, *tool);
}

}  // namespace
}  // namespace rubicon::tuples::dds
