#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "apps/simulators/motes/world.h"
#include "base/virtual_scheduler.h"
#include "motes/framing.h"
#include "motes/mote_records.h"

namespace rubicon::motes_simulator {

using namespace std::chrono_literals;

/// What came out of a sink: a frame, and when its last byte had left.
struct Came {
  std::uint8_t protocol = 0, sequence = 0;
  Bytes packet;
  SteadyTime at{};

  motes::NetMessage net() const { return motes::decode_net(ByteView(packet).subspan(motes::kAmOverhead)).value(); }
};

/// A world in virtual time whose first sink's serial line is in a test's hands.
class SimulatedSink : public ::testing::Test {
 protected:
  /// Motes 2 and 3 as in the recordings, whose sensors need no time, everything without chance.
  static WorldOptions plain() {
    WorldOptions options;
    MoteOptions mote;
    mote.stale = 0;
    mote.sensor_time = {};
    options.add_motes(1, 2, 2, mote);
    options.sink.stale = 0;
    options.sink.ack = {50ms, 50ms, 50ms, 0};
    return options;
  }
  void make(WorldOptions options, std::string_view script = "", bool listen = true) {
    auto steps = parse_script(script);
    ASSERT_TRUE(steps) << steps.error().text;
    world = std::make_unique<World>(std::move(options), time, *steps, [this](const Event& event) {
      events.push_back(event);
      lines.push_back(to_json(event));
    });
    if (listen) world->sink(1).connect([this](ByteView bytes) { take(bytes); });
  }
  void joined(WorldOptions options = plain()) {
    make(std::move(options));
    time.run_for(2s);
    came.clear();
    events.clear();
  }

  void take(ByteView bytes) {
    out.insert(out.end(), bytes.begin(), bytes.end());
    while (auto frame = reader.next(bytes))
      came.push_back({frame->protocol, frame->sequence, {frame->packet.begin(), frame->packet.end()}, time.now()});
  }
  void send(ByteView bytes) { world->sink(1).received(bytes); }
  void send(std::uint8_t sequence, const motes::NetMessage& message) {
    send(motes::hdlc_acked_packet(sequence, motes::packet_of(message)));
  }

  std::vector<std::uint8_t> acks() const {
    std::vector<std::uint8_t> all;
    for (const auto& one : came) {
      if (one.protocol == motes::kHdlcAck) all.push_back(one.sequence);
    }
    return all;
  }
  std::vector<Came> packets(std::uint16_t from = 0, int transport = -1) const {
    std::vector<Came> all;
    for (const auto& one : came) {
      if (one.protocol != motes::kHdlcPacket) continue;
      const auto net = one.net();
      if ((from == 0 || net.source_mote == from) && (transport < 0 || net.transport == transport)) all.push_back(one);
    }
    return all;
  }
  /// The numbers of the messages that were acknowledged by an application, as `record` says.
  std::vector<std::uint16_t> acknowledged(std::uint16_t by) const {
    std::vector<std::uint16_t> all;
    for (const auto& one : packets(by, motes::kTransportAck)) {
      const auto record = one.net().record;
      all.push_back(static_cast<std::uint16_t>(record[1] << 8U | record[2]));
    }
    return all;
  }
  std::vector<std::uint16_t> lights(std::uint16_t of) const {
    std::vector<std::uint16_t> all;
    for (const auto& one : packets(of, motes::kTransportConnectionless)) {
      const auto record = one.net().record;
      if (record[0] == 0x22) all.push_back(static_cast<std::uint16_t>(record[1] << 8U | record[2]));
    }
    return all;
  }
  std::size_t count(std::string_view what, std::uint16_t mote = 0) const {
    return static_cast<std::size_t>(std::count_if(events.begin(), events.end(), [&](const Event& event) {
      return event.what == what && (mote == 0 || event.mote == mote);
    }));
  }

  VirtualScheduler time;
  std::unique_ptr<World> world;
  motes::HdlcReader reader;
  Bytes out;
  std::vector<Came> came;
  std::vector<Event> events;
  std::vector<std::string> lines;
};

/// A command from the computer of island 11: `01 0043 03e8` and so on.
inline motes::NetMessage command(std::uint16_t to, ByteView record, std::uint16_t sequence = 0x1234,
                                 std::uint8_t reliable = 0, std::uint8_t application = 5) {
  return {11, to, 11, motes::kBaseMote, reliable, sequence, 0, motes::kTransportConnectionless, application, record};
}
inline Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

}  // namespace rubicon::motes_simulator
