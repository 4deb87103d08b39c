#include "apps/simulators/motes/radio.h"

#include <algorithm>
#include <utility>

namespace rubicon::motes_simulator {

namespace {

using namespace std::chrono_literals;

/// From the decision to send until others can detect it: turnaround and the symbols that carrier sense needs.
constexpr Duration kBlind = 320us;
constexpr std::size_t kOverhead = 19;
constexpr Duration kByte = 32us;

Duration ticks(unsigned count) {
  return Duration(std::chrono::nanoseconds(1'000'000'000ULL * count / 32768));
}

}  // namespace

Radio::Radio(RadioOptions options, Scheduler& scheduler)
    : options_(options), scheduler_(scheduler), rng_(options.seed) {}

Duration Radio::airtime(std::size_t payload) {
  return kByte * static_cast<int>(payload + kOverhead);
}

Radio::Node Radio::add(RadioNode& node, Cells cells) {
  nodes_.push_back({&node, {}, 0});
  place(nodes_.size() - 1, std::move(cells));
  return nodes_.size() - 1;
}

void Radio::place(Node node, Cells cells) {
  for (const auto cell : nodes_[node].cells) std::erase(cells_[cell].nodes, node);
  for (const auto cell : cells) cells_[cell].nodes.push_back(node);
  nodes_[node].cells = std::move(cells);
}

bool Radio::busy(Node node) const {
  const auto now = scheduler_.now();
  return std::any_of(nodes_[node].cells.begin(), nodes_[node].cells.end(), [&](auto number) {
    const auto& cell = cells_.at(number);
    return cell.ends > now && (cell.began + kBlind <= now || !options_.collisions);
  });
}

void Radio::occupy(std::uint64_t id, Flight& flight, SteadyTime ends) {
  const auto now = scheduler_.now();
  for (const auto number : nodes_[flight.from].cells) {
    auto& cell = cells_[number];
    const bool collides = options_.collisions && cell.ends > now;
    if (!collides) flight.heard_in.push_back(number);
    if (const auto other = flights_.find(cell.flight); collides && other != flights_.end())
      std::erase(other->second.heard_in, number);
    if (!collides) cell.began = now;
    cell.ends = std::max(cell.ends, ends);
    cell.flight = id;
  }
}

void Radio::transmit(Node from, AirMessage message, std::function<void(bool)> done) {
  const auto ends = scheduler_.now() + airtime(message.payload.size());
  const auto id = ++last_flight_;
  Flight flight{from, std::move(message), std::move(done), {}, {}};
  occupy(id, flight, ends);
  if (flights_.size() >= kMaxInFlight) flight.heard_in.clear();
  flight.landing = scheduler_.at(ends + options_.delay, [this, id] { land(id); });
  flights_.emplace(id, std::move(flight));
}

bool Radio::by_chance(double share) {
  return share > 0 && std::uniform_real_distribution<>(0, 1)(rng_) < share;
}

bool Radio::deliver(const Flight& flight, Node to) {
  const auto lost = [&] {
    return by_chance(options_.loss) || by_chance(nodes_[flight.from].loss) || by_chance(nodes_[to].loss);
  };
  if (lost()) return false;
  const bool taken = nodes_[to].node->hear(flight.message);
  if (by_chance(options_.duplicates)) nodes_[to].node->hear(flight.message);
  return taken && !lost();  // the acknowledgement may be lost too
}

void Radio::land(std::uint64_t id) {
  const auto landed = std::move(flights_.extract(id).mapped());
  std::vector<Node> receivers;
  for (const auto cell : landed.heard_in) {
    for (const auto node : cells_[cell].nodes) {
      if (node != landed.from && std::find(receivers.begin(), receivers.end(), node) == receivers.end())
        receivers.push_back(node);
    }
  }
  bool acknowledged = false;
  for (const auto node : receivers) acknowledged = deliver(landed, node) || acknowledged;
  if (landed.done) landed.done(acknowledged && landed.message.destination != 0xffff);
}

void Transmitter::start(Radio::Node node, std::uint16_t address) {
  stop();
  node_ = node;
  random_ = TinyosRandom(address);
  on_ = true;
}

void Transmitter::stop() {
  on_ = false;
  stalls_ = false;
  ++start_count_;
  queue_.clear();
  back_off_.cancel();
}

bool Transmitter::send(AirMessage message, SentCallback sent) {
  if (!on_ || queue_.size() >= kQueue) return false;
  queue_.push_back({std::move(message), std::move(sent)});
  if (queue_.size() == 1) next();
  return true;
}

void Transmitter::next() {
  if (queue_.empty() || stalls_) return;
  back_off_ = scheduler_.after(ticks(10U + random_.next() % 310U), [this] { try_now(); });
}

void Transmitter::try_now() {
  if (radio_.busy(node_)) {
    back_off_ = scheduler_.after(ticks(10U + random_.next() % 70U), [this] { try_now(); });
    return;
  }
  radio_.transmit(node_, queue_.front().message, [this, start = start_count_](bool acknowledged) {
    if (start != start_count_) return;
    const auto gone = std::move(queue_.front());
    queue_.pop_front();
    next();
    if (gone.sent) gone.sent(acknowledged);
  });
}

}  // namespace rubicon::motes_simulator
