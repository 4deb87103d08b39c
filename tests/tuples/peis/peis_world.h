#pragma once

#include <algorithm>
#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"
#include "tuples/peis/node.h"

namespace rubicon::tuples::peis {

using namespace std::chrono_literals;

inline void PrintTo(HostEvent event, std::ostream* out) {
  static constexpr const char* kNames[]{"up", "hello", "back", "forgot", "left", "lost"};
  *out << kNames[static_cast<int>(event)];
}

/// One machine in virtual time.
struct PeisWorld {
  PeisWorld() { machine.join(net); }
  void run(Duration span) { time.run_for(span); }
  /// Until it is so, at most for `span`; the time that it took.
  template <class So>
  Duration until(So so, Duration span) {
    const auto start = time.now();
    while (!so() && time.now() - start < span) time.run_for(10ms);
    return time.now() - start;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};
  transport::MemoryTransports machine;
  support::CollectingLog sink;
  std::vector<transport::Interface> interfaces{{"lo", "127.0.0.1", true, true, true}};
};

/// A node of ours with all that it reported.
struct OwnNode {
  struct Message {
    OwnerId from{};
    Port port{};
    std::string body;
    friend bool operator==(const Message&, const Message&) = default;
  };
  struct Event {
    HostEvent event{};
    Identity host;
    SteadyTime at{};
  };

  explicit OwnNode(PeisWorld& w, std::uint32_t id) : world(w) {
    options.id = OwnerId{id};
    options.magic = 0x1000000 + id;
    options.host_name = "hostx";
    options.full_name = "ours@hostx!" + std::to_string(id);
    options.hello.incarnation = 1000 + id;
    options.hello.host_id = "host-of-hostx";
    options.interfaces = world.interfaces;
  }
  Result<void> open() { return open(world.machine); }
  Result<void> open(transport::Transports& transports) {
    NodeCallbacks calls;
    calls.message = [this](OwnerId from, Port port, ByteView body) {
      messages.push_back({from, port, std::string(base::as_text(body))});
      if (on_message) on_message(messages.back());
    };
    calls.host = [this](HostEvent event, const Identity& host) { events.push_back({event, host, world.time.now()}); };
    calls.ready = [this](OwnerId to) { ready.push_back(to); };
    calls.id_taken = [this](const Identity& other) { taken.push_back(other); };
    auto opened = Node::open(options, world.time, transports, Log(world.sink, "peis"), std::move(calls));
    if (!opened) return fail(opened.error());
    node = std::move(*opened);
    return {};
  }
  Result<void> send(std::uint32_t to, const std::string& text, Port port = Port::kPush) {
    return node->send(OwnerId{to}, port, base::as_bytes(text),
                      [this](Outcome outcome) { outcomes.push_back(outcome); });
  }
  bool sees(std::uint32_t id) const { return node->host(OwnerId{id}) != nullptr; }
  std::vector<HostEvent> events_of(std::uint32_t id) const {
    std::vector<HostEvent> found;
    for (const auto& event : events) {
      if (event.host.id == OwnerId{id}) found.push_back(event.event);
    }
    return found;
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> found;
    for (const auto& message : messages) found.push_back(message.body);
    return found;
  }

  PeisWorld& world;
  NodeOptions options;
  std::unique_ptr<Node> node;
  std::function<void(const Message&)> on_message;
  std::vector<Message> messages;
  std::vector<Event> events;
  std::vector<OwnerId> ready;
  std::vector<Identity> taken;
  std::vector<Outcome> outcomes;
};

}  // namespace rubicon::tuples::peis
