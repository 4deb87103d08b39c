#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "rubicon/tuple_space.hpp"
#include "support/collecting_log.h"
#include "support/memory/memory_folder.h"
#include "tuples/component.h"
#include "tuples/host/host_ecology.h"

namespace rubicon::tuples::host {

using namespace std::chrono_literals;

inline constexpr OwnerId kIsland{6541}, kTool{70001}, kOther{70002};

/// A process with its components.
struct Program {
  struct Member {
    Member(HostEcology& ecology, Scheduler& time, OwnerId id)
        : link(std::move(*ecology.join(id))), space(id, time, *link) {}
    std::unique_ptr<Link> link;
    TupleSpace space;
  };

  Program(MemoryHost& host, VirtualScheduler& t, pid_t n, const HostOptions& options = {}, uid_t user = 1000,
          bool islands = true)
      : time(t), number(n), ecology(std::move(*HostEcology::open(host.enter(user, islands), options, t, log))) {}
  TupleSpace& start(OwnerId id) {
    auto& one = *members.emplace(id, std::make_unique<Member>(*ecology, time, id)).first->second;
    watches.push_back(one.space.watch_peers([this, id](OwnerId peer, PeerEvent event) {
      const auto* what = event == PeerEvent::kUp ? " met " : event == PeerEvent::kLeft ? " saw leave " : " lost ";
      seen.push_back(std::to_string(model::number(id)) + what + std::to_string(model::number(peer)));
    }));
    return one.space;
  }
  std::vector<std::string> take() { return std::exchange(seen, {}); }

  VirtualScheduler& time;
  pid_t number;
  support::CollectingLog log;
  std::unique_ptr<HostEcology> ecology;
  std::map<OwnerId, std::unique_ptr<Member>> members;
  std::vector<Handle> watches;
  std::vector<std::string> seen;
};

struct HostEcologyInMemory : testing::Test {
  std::unique_ptr<Program> begin(const HostOptions& options = {}, uid_t user = 1000, bool islands = true) {
    return std::make_unique<Program>(host, time, ++programs, options, user, islands);
  }
  /// What the space has of the owner's tuple: `on`, or empty.
  static std::string value(const TupleSpace& space, OwnerId owner, std::string_view key) {
    const auto found = space.get(owner, key);
    return found ? std::string(found->value) : std::string();
  }
  [[nodiscard]] static Handle read_all(TupleSpace& space) {
    return space.subscribe(pattern("**"), {}, [](const Event&) {});
  }

  VirtualScheduler time;
  MemoryHost host{time};
  pid_t programs = 0;
};

}  // namespace rubicon::tuples::host
