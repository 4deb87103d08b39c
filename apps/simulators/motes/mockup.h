#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>

#include "apps/simulators/motes/sensors.h"
#include "apps/simulators/motes/tinyos_random.h"
#include "base/scheduler.h"
#include "motes/mote_packet.h"

namespace rubicon::motes_simulator {

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
