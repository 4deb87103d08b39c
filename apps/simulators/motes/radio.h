#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "apps/simulators/motes/tinyos_random.h"
#include "base/bytes.h"
#include "base/scheduler.h"

namespace rubicon::motes_simulator {

/// AM types on the air (wsn.md 8).
inline constexpr std::uint8_t kAirJoinRequest = 0x0e;
inline constexpr std::uint8_t kAirJoinReply = 0x0f;
inline constexpr std::uint8_t kAirAckJoin = 0x1d;
inline constexpr std::uint8_t kAirNetMessage = 0x1c;

/// Longest payload of a radio message (wsn.md 8).
inline constexpr std::size_t kAirPayload = 114;

/// A message on the air; `destination` ffff = all who hear it.
struct AirMessage {
  std::uint8_t type = 0;
  std::uint16_t destination = 0;
  std::uint16_t source = 0;
  Bytes payload;
};

/// What hears the radio.
class RadioNode {
 public:
  virtual ~RadioNode() = default;
  /// True: it was for this node, whose radio acknowledges it if one destination was named.
  virtual bool hear(const AirMessage& message) = 0;
};

struct RadioOptions {
  double loss = 0;         ///< share of the messages that a receiver does not get
  double duplicates = 0;   ///< share that it gets twice
  Duration delay{};        ///< on top of the time on the air
  bool collisions = true;  ///< two that begin at the same moment are lost, as in reality
  std::uint64_t seed = 1;
};

/// The air of channel 26, in cells: one for each sink. Who is in the same cell hears each other; a mote may be in
/// several. Scheduler and nodes outlive it.
class Radio {
 public:
  using Node = std::size_t;
  using Cells = std::vector<std::uint16_t>;
  /// Messages on the air at a time; more are lost.
  static constexpr std::size_t kMaxInFlight = 10000;

  Radio(RadioOptions options, Scheduler& scheduler);

  Node add(RadioNode& node, Cells cells);
  /// It moved: from now on these cells hear it.
  void place(Node node, Cells cells);
  const Cells& cells(Node node) const { return nodes_[node].cells; }
  RadioOptions& options() { return options_; }
  /// Of the links of one node, on top of the loss that all have.
  void set_loss(Node node, double loss) { nodes_[node].loss = loss; }

  /// Carrier sense: somebody's message is on the air there, and has been for long enough to be noticed.
  bool busy(Node node) const;
  /// `done` is called in a later turn, when it has gone; true: a hardware acknowledgement came.
  void transmit(Node from, AirMessage message, std::function<void(bool acknowledged)> done);

  /// 250 kbit/s, 19 bytes around the payload: 4.26 ms for 114 bytes, 1.50 ms for 28 (wsn.md 8).
  static Duration airtime(std::size_t payload);

 private:
  struct Flight {
    Node from = 0;
    AirMessage message;
    std::function<void(bool)> done;
    Cells heard_in;  ///< where no other message spoilt it
    Timer lands;
  };
  struct Place {
    RadioNode* node = nullptr;
    Cells cells;
    double loss = 0;
  };
  struct Cell {
    std::vector<Node> nodes;
    SteadyTime began{}, ends{};
    std::uint64_t flight = 0;  ///< the latest
  };

  void occupy(std::uint64_t id, Flight& flight, SteadyTime ends);
  void land(std::uint64_t id);
  bool deliver(const Flight& flight, Node to);
  bool by_chance(double share);

  RadioOptions options_;
  Scheduler& scheduler_;
  std::vector<Place> nodes_;
  std::map<std::uint16_t, Cell> cells_;
  std::map<std::uint64_t, Flight> flights_;
  std::uint64_t last_flight_ = 0;
  std::mt19937_64 rng_;
};

/// A node's own radio stack: a queue of 4 (wsn.md 12), and before each message a random back-off, as TinyOS does it for
/// the CC2420 (initial 10 to 319, congested 10 to 79 ticks of 1/32768 s).
class Transmitter {
 public:
  using SentCallback = std::function<void(bool acknowledged)>;
  static constexpr std::size_t kQueue = 4;

  Transmitter(Radio& radio, Scheduler& scheduler) : radio_(radio), scheduler_(scheduler) {}

  void start(Radio::Node node, std::uint16_t address);
  /// Power is gone, and with it all that waits; the next start() begins the random numbers anew.
  void stop();
  /// False: the queue was full, and it is lost.
  bool send(AirMessage message, SentCallback sent = {});
  /// The next send fails, and with it the queue stops for ever (wsn.md 14, 38), that is until the next start().
  void stall() { stalls_ = true; }
  TinyosRandom& random() { return random_; }

 private:
  struct Waiting {
    AirMessage message;
    SentCallback sent;
  };
  void next();
  void try_now();

  Radio& radio_;
  Scheduler& scheduler_;
  Radio::Node node_ = 0;
  TinyosRandom random_{0};
  std::deque<Waiting> queue_;
  bool on_ = false, stalls_ = false;
  std::uint64_t life_ = 0;  ///< what left in an earlier life is not ours any more
  Timer back_off_;
};

}  // namespace rubicon::motes_simulator
