#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "apps/simulators/motes/mockup.h"
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

/// A message on the air; destination ffff: broadcast.
struct AirMessage {
  std::uint8_t type = 0;
  std::uint16_t destination = 0;
  std::uint16_t source = 0;
  Bytes payload;
};

/// A receiver.
class RadioNode {
 public:
  virtual ~RadioNode() = default;
  /// True: the message was for this node; its radio acknowledges it unless it was a broadcast.
  virtual bool hear(const AirMessage& message) = 0;
};

struct RadioOptions {
  double loss = 0;         ///< share of the messages that a receiver misses
  double duplicates = 0;   ///< share that a receiver gets twice
  Duration delay{};        ///< in addition to the time on the air
  bool collisions = true;  ///< messages that start simultaneously are lost, as in reality
  std::uint64_t seed = 1;
};

/// Radio channel 26, divided into cells, one for each sink. Nodes of a cell hear each other; a mote may be in several
/// cells. Scheduler and nodes must outlive it.
class Radio {
 public:
  using Node = std::size_t;
  using Cells = std::vector<std::uint16_t>;
  /// Messages on the air at a time; more are lost.
  static constexpr std::size_t kMaxInFlight = 10000;

  Radio(RadioOptions options, Scheduler& scheduler);

  Node add(RadioNode& node, Cells cells);
  /// Moves a node to other cells.
  void place(Node node, Cells cells);
  const Cells& cells(Node node) const { return nodes_[node].cells; }
  RadioOptions& options() { return options_; }
  /// Additional loss on the links of one node.
  void set_loss(Node node, double loss) { nodes_[node].loss = loss; }

  /// Carrier sense: a message has been on the air in the node's cells long enough to be detected.
  bool busy(Node node) const;
  /// `done` is called in a later turn, when the message was sent; true: a hardware acknowledgement came.
  void transmit(Node from, AirMessage message, std::function<void(bool acknowledged)> done);

  /// 250 kbit/s, 19 bytes around the payload: 4.26 ms for 114 bytes, 1.50 ms for 28 (wsn.md 8).
  static Duration airtime(std::size_t payload);

 private:
  struct Flight {
    Node from = 0;
    AirMessage message;
    std::function<void(bool)> done;
    Cells heard_in;  ///< cells in which no other message collided with it
    Timer landing;
  };
  struct NodeState {
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
  std::vector<NodeState> nodes_;
  std::map<std::uint16_t, Cell> cells_;
  std::map<std::uint64_t, Flight> flights_;
  std::uint64_t last_flight_ = 0;
  std::mt19937_64 rng_;
};

/// The radio stack of a node: a queue of 4 messages (wsn.md 12), and before each a random back-off, as in TinyOS for
/// the CC2420 (initial 10 to 319, congested 10 to 79 ticks of 1/32768 s).
class Transmitter {
 public:
  using SentCallback = std::function<void(bool acknowledged)>;
  static constexpr std::size_t kQueue = 4;

  Transmitter(Radio& radio, Scheduler& scheduler) : radio_(radio), scheduler_(scheduler) {}

  void start(Radio::Node node, std::uint16_t address);
  /// Power off: discards the queue. The next start() restarts the random numbers.
  void stop();
  /// False: the queue is full, the message is lost.
  bool send(AirMessage message, SentCallback sent = {});
  /// The next send fails and stops the queue (wsn.md 14, 38) until the next start().
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
  std::uint64_t start_count_ = 0;  ///< identifies messages sent before a restart
  Timer back_off_;
};

}  // namespace rubicon::motes_simulator
