#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/collecting_log.h"
#include "tuples/component.h"
#include "tuples/joined/joined_ecology.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::tuples::joined {

inline std::string event_name(PeerEvent event) {
  return event == PeerEvent::kUp ? "up" : event == PeerEvent::kLeft ? "left" : "lost";
}

/// One component, and what it saw of the others: `70000 up`.
struct Observer {
  Observer(Ecology& ecology, VirtualScheduler& time, std::uint32_t id)
      : link(std::move(*ecology.join(OwnerId(id)))), space(OwnerId(id), time, *link) {}
  Reply set(VirtualScheduler& time, std::uint32_t owner, std::string_view key, std::string_view value) {
    Reply answer{{}, 0, Verdict::kExpired, {}, "no reply", 0};
    space.set_remote(OwnerId(owner), key, value, {}, [&answer](const Reply& reply) { answer = reply; });
    time.run_ready();
    return answer;
  }
  std::string value(std::uint32_t owner, std::string_view key) const {
    const auto tuple = space.get(OwnerId(owner), key);
    return tuple ? std::string(tuple->value) : "absent";
  }
  Seen take() { return std::exchange(events, {}); }

  std::unique_ptr<Link> link;
  TupleSpace space;
  Seen events;
  Handle watch = space.watch_peers([this](OwnerId peer, PeerEvent event) {
    events.push_back(std::to_string(number(peer)) + " " + event_name(event));
  });
};

/// Components on `dds`, on `peis`, and on both.
struct TwoEngines : testing::Test {
  /// A second starts at each call, so that no two components have the same start.
  std::unique_ptr<Observer> join(Ecology& ecology, std::uint32_t id) {
    time.run_for(std::chrono::seconds(1));
    auto component = std::make_unique<Observer>(ecology, time, id);
    time.run_ready();
    return component;
  }

  VirtualScheduler time;
  support::CollectingLog log;
  MemoryEcology dds{time, "here"}, peis{time, "there"};
  JoinedEcology both{{{"dds", dds}, {"peis", peis}}, time, log};
};

}  // namespace rubicon::tuples::joined
