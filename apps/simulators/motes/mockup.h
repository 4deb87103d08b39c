#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <random>

#include "apps/simulators/motes/sensors.h"
#include "base/scheduler.h"
#include "motes/mote_packet.h"

namespace rubicon::motes_simulator {

/// The random numbers of TinyOS (RandomMlcgP: Park and Miller's generator, seeded with the node id + 1). The sequence
/// numbers of motes 2 and 3 and of sink 1 in the recordings come from it (247f is number 3 of mote 2); the numbers
/// between them are the radio's back-offs. That is why they repeat after each reboot (wsn.md 9.2).
class TinyosRandom {
 public:
  explicit TinyosRandom(std::uint16_t node) : seed_(node + 1U) {}

  std::uint16_t next() {
    const std::uint64_t product = std::uint64_t{33614} * seed_;
    const auto low = static_cast<std::uint32_t>(product) >> 1U;
    std::uint32_t sum = low + static_cast<std::uint32_t>(product >> 32U);
    if ((sum & 0x80000000U) != 0) sum = (sum & 0x7fffffffU) + 1;
    seed_ = sum;
    return static_cast<std::uint16_t>(seed_);
  }

 private:
  std::uint32_t seed_;
};

/// Bytes for a record after NetMsg header, transport and application (wsn.md 12).
inline constexpr std::size_t kRecordRoom = 100;
inline constexpr std::size_t kNetHeader = 12;
/// The nbytes field of everything that a mote sends, whatever its length (wsn.md 5).
inline constexpr std::uint8_t kFullCount = 0x66;

/// The message buffers of a firmware. They are reused and not always cleared, so that parts of older messages follow a
/// record (wsn.md 5).
class MessageMemory {
 public:
  /// `stale`: share of the messages in which parts of an older one follow the record; in the others zeros do.
  MessageMemory(double stale, std::uint64_t seed) : stale_(stale), rng_(seed) {}

  /// 114 bytes: the message, its record, and the previous content of the buffer.
  Bytes build(motes::NetMessage message);
  /// In an acknowledgement one further byte follows the record, which differs between recordings.
  Bytes build_ack(motes::NetMessage message);
  void clear() { last_.clear(); }
  std::mt19937_64& rng() { return rng_; }

 private:
  using Room = std::array<std::uint8_t, kRecordRoom>;
  Room room();
  Bytes wrap(motes::NetMessage& message, const Room& room);

  double stale_;
  std::mt19937_64 rng_;
  Bytes last_;  ///< the previous message
};

/// Source or destination of a message.
struct Peer {
  std::uint16_t island = 0, mote = 0;
};

/// TinyOS milliseconds: 1/1024 s (wsn.md 9.4).
Duration tinyos_ms(std::uint32_t count);

struct MockupOptions {
  std::uint16_t transducers = 0;  ///< that the board really has: `updates` reads these
  /// From the start of a measurement to its value: 210 ms for the SHT11's 14 bits. 0: immediately, as with the sensor
  /// stubs of the recordings.
  Duration sensor_time = std::chrono::milliseconds(210);
  bool obey = false;     ///< extension: executes Actuate, and LED adds light
  bool updates = false;  ///< extension: answers READ_UPDATES of application 10 with UPDATES
};

/// The application of the released firmware, Mockup-WSN (wsn.md 9.4, 9.5), and the extensions of a mote with the
/// Control module.
class Mockup {
 public:
  struct Callbacks {
    std::function<void(Peer to, std::uint8_t application, ByteView record)> send;
    std::function<void(std::uint16_t actuator, std::int32_t value)> actuated;
  };
  /// Counts that a lit LED adds to the light.
  static constexpr unsigned kLedLight = 200;

  Mockup(MockupOptions options, Sensors& sensors, TinyosRandom& random, Scheduler& scheduler, Callbacks callbacks);

  /// A message of transport 3; false: unknown to the application, ignored.
  bool take(const motes::NetMessage& message);
  void reset();

 private:
  bool take_mockup(const motes::NetMessage& message);
  void periodic(const motes::NetMessage& message);
  void actuate(ByteView record);
  void read_updates(const motes::NetMessage& message);
  void tick();
  void flood_tick();
  void updates_tick();
  void read(std::uint16_t mask);
  void measure(std::size_t sensor);
  void report();
  std::uint16_t reading(std::size_t sensor);
  void schedule(Timer& timer, SteadyTime& due, Duration period, void (Mockup::*then)());

  MockupOptions options_;
  Sensors& sensors_;
  TinyosRandom& random_;
  Scheduler& scheduler_;
  Callbacks callbacks_;
  Peer requester_, updates_for_;
  std::uint16_t mask_ = 0, updates_mask_ = 0;
  Duration period_{}, updates_period_{};
  std::map<std::uint16_t, std::int32_t> actuators_;
  SteadyTime due_{}, updates_due_{};
  /// Light and temperature in the record of the next report: zero from boot to the first measurement.
  std::array<std::uint16_t, 2> measured_{};
  std::array<Timer, 2> measuring_;
  Timer timer_, updates_timer_;
};

}  // namespace rubicon::motes_simulator
