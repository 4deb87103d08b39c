#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "tuples/peis/kernel_peer.h"
#include "tuples/peis/peis_link.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::tuples::peis {

inline constexpr OwnerId kSelf{200}, kKernel{101};

inline std::string text_of(const Bytes& bytes) {
  return std::string(base::as_text(bytes));
}

inline std::string c_string(std::string_view text) {
  return std::string(text) + '\0';
}

/// A component of ours with a simulated kernel.
class LinkToAKernel : public ::testing::Test {
 protected:
  explicit LinkToAKernel(std::shared_ptr<Judge> judge = nullptr) {
    kernel.listen();
    PeisOptions options;
    options.judge = std::move(judge);
    options.multicast = false;
    options.connect = {"127.0.0.1:9000"};
    const PeisMachine machine{world.interfaces, "hostx", "host-of-hostx", "4711", "anna"};
    link = std::make_unique<PeisLink>(kSelf, PeisLink::Settings{options, world.interfaces, machine}, world.time,
                                      world.machine, log, nullptr);
    space = std::make_unique<TupleSpace>(kSelf, world.time, *link);
    world.run(1s);
  }

  void subscribe(std::string_view key, bool force = true) {
    Subscribe out;
    out.force_resend = force;
    out.prototype.owner = kSelf;
    out.prototype.key = key;
    kernel.send(200, Port::kSubscribe, text_of(write(out)));
  }
  void unsubscribe(std::string_view key) {
    Unsubscribe out;
    out.owner = kSelf;
    out.key = key;
    kernel.send(200, Port::kUnsubscribe, text_of(write(out)));
  }
  NetworkTuple tuple(OwnerId owner, std::string_view key, std::string_view data) {
    NetworkTuple out;
    out.owner = owner;
    out.creator = kKernel;
    out.key = key;
    out.write_time = world.time.wall_now();
    out.user_time = out.expire_time = WallTime{};
    out.encoding = Encoding::kAscii;
    out.media_type = "text/plain";
    out.data = data;
    out.sequence = 0;
    return out;
  }
  void push(std::string_view key, const std::string& value, std::uint32_t number) {
    const auto data = c_string(value);
    auto out = tuple(kKernel, key, data);
    out.sequence = number;
    kernel.send(200, Port::kPush, text_of(write_push(out)));
  }
  void set_remote(std::string_view key, const std::string& data) {
    kernel.send(200, Port::kSetRemote, text_of(write_set_remote(tuple(kSelf, key, data))));
  }

  /// Pushes that the kernel received since the last call: `key=data`, `key=` and the data of a delete.
  struct Pushed {
    std::string key, data;
    std::uint32_t number = 0;
    bool is_delete = false;
  };
  std::vector<Pushed> pushed() {
    std::vector<Pushed> found;
    for (; taken < kernel.messages.size(); ++taken) {
      const auto& message = kernel.messages[taken];
      if (message.header.port != Port::kPush) continue;
      const auto read = read_push(base::as_bytes(message.body));
      EXPECT_TRUE(read) << message.body;
      EXPECT_EQ(read->owner, kSelf);
      EXPECT_EQ(read->annex, Annex{}) << "nothing of ours goes to kernels";
      found.push_back(
          {std::string(read->key), std::string(*read->data), *read->sequence, *read->expire_time == kDeleteTime});
    }
    return found;
  }
  /// Those of the own tuples, without kernel.*.
  std::vector<std::string> own_pushed() {
    std::vector<std::string> found;
    for (const auto& push : pushed()) {
      if (!push.key.starts_with("kernel.")) found.push_back(push.key + (push.is_delete ? " deleted" : "=" + push.data));
    }
    return found;
  }
  std::vector<std::string> subscribed() const {
    std::vector<std::string> keys;
    for (const auto& message : kernel.messages) {
      if (message.header.port == Port::kSubscribe)
        keys.push_back(std::string(read_subscribe(base::as_bytes(message.body))->prototype.key));
    }
    return keys;
  }
  EventCall note() {
    return [this](const Event& event) {
      const std::string key(event.tuple.key);
      seen.push_back(event.kind == EventKind::kSet ? key + "=" + std::string(event.tuple.value)
                                                   : key + " " + std::string(to_string(event.kind)));
    };
  }
  std::vector<std::string> take() { return std::exchange(seen, {}); }
  const SessionCounters& counters() const { return link->presence()->counters(); }

  PeisWorld world;
  support::CollectingLog log;
  KernelPeer kernel{world, 101, 9000};
  std::unique_ptr<PeisLink> link;
  std::unique_ptr<TupleSpace> space;
  std::size_t taken = 0;
  std::vector<std::string> seen;
};

}  // namespace rubicon::tuples::peis
