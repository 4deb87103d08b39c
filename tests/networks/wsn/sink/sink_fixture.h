#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "motes/framing.h"
#include "motes/mote_packet.h"
#include "networks/wsn/sink/stream_sinks.h"
#include "support/memory/memory_serial.h"
#include "support/memory/memory_transports.h"

namespace rubicon::networks::wsn::sink {

using namespace std::chrono_literals;

inline Bytes hex(std::string_view text) {
  return base::from_hex(text).value();
}

/// SET_ISLAND_ID as a packet (wsn.md 15).
inline Bytes set_island(std::uint16_t island) {
  auto packet = hex("00000100000300250a0000");
  packet[9] = static_cast<std::uint8_t>(island >> 8);
  packet[10] = static_cast<std::uint8_t>(island & 0xff);
  return packet;
}

/// A packet of 12 bytes that carries a number.
inline Bytes numbered(std::uint16_t number) {
  return {
      0,    0, 1, 0, 0, 4, 0, 0x1c, static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number & 0xff),
      0x7e, 0};
}

inline std::uint16_t number_in(ByteView packet) {
  return static_cast<std::uint16_t>(packet[8] << 8 | packet[9]);
}

/// The computer's end of a sink as section 10 of wsn.md measured it: acks every valid 44, and executes only what comes
/// when it has acked what came before.
class FakeSink {
 public:
  struct Heard {
    SteadyTime when;
    std::uint8_t sequence;
    Bytes packet;
  };

  explicit FakeSink(Scheduler& scheduler) : scheduler_(scheduler) {}

  /// On a port, for one connection after the other.
  void listen(transport::MemoryNet& net, const transport::Endpoint& at) {
    listener_ = net.tcp.listen(at, [this](auto stream) {
      ++connections;
      stream_ = std::move(stream);
      return begin();
    });
  }
  /// On a serial line; hang_up() unplugs.
  void plug(transport::MemorySerial& serial, const std::string& path) { stream_ = serial.plug(path, begin()); }

  void say(ByteView packet) { say_raw(motes::hdlc_packet(packet)); }
  void say_raw(ByteView bytes) { ASSERT_TRUE(stream_ && stream_->send(bytes)); }
  void ack(std::uint8_t sequence) { say_raw(motes::hdlc_ack(sequence)); }
  void hang_up() { stream_.reset(); }
  bool connected() const { return stream_ != nullptr; }

  Duration ack_delay = 50ms;
  bool answers = true;
  std::function<void(const Heard&)> instead;  ///< of the ack
  Bytes raw;                                  ///< all that came
  std::vector<Heard> heard;                   ///< its 44 frames
  std::vector<std::uint8_t> acks;             ///< sequence numbers acked to it
  std::vector<Bytes> executed;
  std::size_t connections = 0;

 private:
  transport::StreamCallbacks begin() {
    reader_.reset();
    pending_.clear();
    transport::StreamCallbacks calls;
    calls.received = [this](ByteView bytes) { take(bytes); };
    calls.failed = [this](const Error&) { stream_.reset(); };
    return calls;
  }

  void take(ByteView bytes) {
    raw.insert(raw.end(), bytes.begin(), bytes.end());
    while (const auto frame = reader_.next(bytes)) {
      if (frame->protocol == motes::kHdlcAck) acks.push_back(frame->sequence);
      if (frame->protocol == motes::kHdlcAckedPacket) take_packet(*frame);
    }
  }

  void take_packet(const motes::HdlcFrame& frame) {
    heard.push_back({scheduler_.now(), frame.sequence, Bytes(frame.packet.begin(), frame.packet.end())});
    if (pending_.empty()) executed.push_back(heard.back().packet);
    if (instead) return instead(heard.back());
    if (!answers) return;
    const auto number = ++last_;
    pending_[number] = scheduler_.after(ack_delay, [this, number, sequence = frame.sequence] {
      const auto done = std::move(pending_.extract(number).mapped());
      if (stream_) ack(sequence);
    });
  }

  Scheduler& scheduler_;
  std::unique_ptr<transport::MemoryListener> listener_;
  std::unique_ptr<transport::ByteStream> stream_;
  motes::HdlcReader reader_;
  std::map<int, Timer> pending_;  ///< acks to come
  int last_ = 0;
};

/// What a sink reported, for any kind of source. A lost line is opened again after a pause, as the supervisor would.
class SinkTold : public testing::Test {
 protected:
  using Phase = SinkState::Phase;

  SinkTold() {
    transports.join(net, "10.0.0.2");
    options.greeting = set_island(42);
  }

  SinkCallbacks calls() {
    SinkCallbacks calls;
    calls.changed = [this](const SinkState& state) { states.push_back(state); };
    calls.failed = [this](Error why) {
      failures.push_back(std::move(why));
      if (reopens) reopen_later();
    };
    calls.received = [this](ByteView packet) {
      received.emplace_back(packet.begin(), packet.end());
      received_at.push_back(time.now());
      if (on_received) on_received();
    };
    calls.sent = [this](ByteView packet) {
      left.emplace_back(packet.begin(), packet.end());
      if (on_left) on_left();
    };
    calls.room = [this](Lane lane) {
      rooms.push_back(lane);
      if (on_room) on_room();
    };
    calls.note = [this](const std::string& subject, std::string_view text) {
      notes.emplace_back(subject, std::string(text));
    };
    return calls;
  }

  void reopen_later() {
    reopening = time.after(reopen_pause, [this] {
      if (!sink->open()) reopen_later();
    });
  }

  struct Options {
    Lane lane = Lane::kCommand;
    Duration lives = 24h;
    bool repeatable = true;
  };
  Result<void> send(std::uint16_t number) { return send(number, Options{}); }
  Result<void> send(std::uint16_t number, Options options) {
    Outgoing packet;
    packet.packet = numbered(number);
    packet.lane = options.lane;
    packet.expires = time.now() + options.lives;
    packet.repeatable = options.repeatable;
    packet.done = [this, number](SendResult what) {
      EXPECT_FALSE(results.contains(number)) << number << " got two results";
      results[number] = what;
    };
    return sink->send(std::move(packet));
  }
  std::optional<SendResult> outcome(std::uint16_t number) const {
    const auto found = results.find(number);
    return found == results.end() ? std::nullopt : std::optional(found->second);
  }
  Phase phase() const { return sink->state().phase; }
  std::uint64_t count(const std::string& name) const { return sink->counters().at(name); }
  bool noted(const std::string& subject) const {
    return std::any_of(notes.begin(), notes.end(), [&](const auto& note) { return note.first == subject; });
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports transports;
  SinkOptions options;
  std::vector<SinkState> states;
  std::vector<Error> failures;
  std::vector<Bytes> received, left;
  std::vector<SteadyTime> received_at;
  std::vector<Lane> rooms;
  std::vector<std::pair<std::string, std::string>> notes;
  std::map<std::uint16_t, SendResult> results;
  std::function<void()> on_received, on_left, on_room;
  bool reopens = true;
  Duration reopen_pause = 500ms;
  Timer reopening;
  std::unique_ptr<Sink> sink;
};

/// A SerialSink on a stream of memory to a FakeSink.
class SerialSinkFixture : public SinkTold {
 protected:
  SerialSinkFixture() {
    options.source = parse_source("network@10.0.0.9:19202").value();
    mote.listen(net, {"10.0.0.9", 19202});
  }

  void make(std::uint8_t first_sequence = 0x0e) {
    sink = std::make_unique<SerialSink>(options, time, transports, calls(), first_sequence);
  }
  void open() { ASSERT_TRUE(sink->open()); }
  /// Made, open and acknowledged.
  void connect(std::uint8_t first_sequence = 0x0e) {
    make(first_sequence);
    open();
    time.run_for(100ms);
    ASSERT_EQ(phase(), Phase::kUp) << sink->state().reason;
    ASSERT_EQ(mote.heard.size(), 1U);
    mote.heard.clear();
    mote.executed.clear();
    mote.raw.clear();
  }
  std::vector<std::uint16_t> executed() const {
    std::vector<std::uint16_t> numbers;
    for (const auto& packet : mote.executed) numbers.push_back(number_in(packet));
    return numbers;
  }

  FakeSink mote{time};
};

}  // namespace rubicon::networks::wsn::sink
