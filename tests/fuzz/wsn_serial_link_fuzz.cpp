#include <cstdlib>

#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/wsn/sink/serial_link.h"

namespace rubicon::fuzz::wsn_serial_link_fuzz {

namespace {

using namespace rubicon::networks::wsn::sink;

/// A link with arbitrary input, and a check that each packet gets one result.
struct Station {
  SerialLink::Callbacks calls() {
    SerialLink::Callbacks all;
    all.write = [](ByteView bytes) {
      if (bytes.size() < 6 || bytes.front() != 0x7e || bytes.back() != 0x7e) std::abort();
    };
    all.unwritten = [this] { return unwritten; };
    all.heard = [] {};
    all.acknowledges = [](bool) {};
    all.failed = [this](const Error& why) {
      if (why.text.empty()) std::abort();
      link.end();
    };
    return all;
  }
  void push(std::uint8_t what) {
    Outgoing packet;
    packet.packet = {0, what, 0x7e, 0x7d};
    packet.lane = static_cast<Lane>(what % kLanes);
    packet.repeatable = (what & 8) != 0;
    if ((what & 16) != 0) packet.expires = time.now() + std::chrono::milliseconds(500);
    packet.done = [this](SendResult) { ++done; };
    if (queue.push(std::move(packet))) ++pushed;
  }

  VirtualScheduler time;
  SinkNotifier notifier{{}};
  SendQueue queue{time, 4, {[this] { link.pump(); }, [](Lane) {}}};
  std::size_t unwritten = 0;
  int pushed = 0, done = 0;
  SerialLink link{{{0, 1, 2}, std::chrono::seconds(1), 3, 0}, time, queue, notifier, calls()};
};

}  // namespace

/// Input: events. 255 moves time, 254 pushes a packet of the next byte, 253 loses the line or makes one, 252 blocks it
/// or frees it, 251 acks the sequence number of the next byte; else a length byte and what the line brings.
FUZZ_TARGET(wsn_serial_link) {
  Station station;
  station.link.begin();
  for (std::size_t at = 0; at < size;) {
    const std::size_t event = data[at++];
    const std::uint8_t next = at < size ? data[at] : 0;
    if (event == 255) {
      station.time.run_for(std::chrono::milliseconds(400));
    } else if (event == 254) {
      station.push(next);
      ++at;
    } else if (event == 253) {
      station.link.up() ? station.link.end() : station.link.begin();
    } else if (event == 252) {
      station.unwritten = station.unwritten == 0 ? 2000 : 0;
    } else if (event == 251) {
      if (station.link.up()) station.link.take(motes::hdlc_ack(next));
      ++at;
    } else {
      const auto take = std::min(event, size - at);
      if (station.link.up()) station.link.take(ByteView(data + at, take));
      at += take;
    }
    station.time.run_ready();
    if (station.done > station.pushed) std::abort();
  }
  station.unwritten = 0;
  if (!station.link.up()) station.link.begin();
  for (int i = 0; i < 50; ++i) {
    station.time.run_for(std::chrono::seconds(4));
    if (!station.link.up()) station.link.begin();
    station.link.take(motes::hdlc_packet(Bytes{0, 1, 2}));  // it is there, but deaf
  }
  station.time.run_for(std::chrono::seconds(4));
  if (station.done != station.pushed) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::wsn_serial_link_fuzz
