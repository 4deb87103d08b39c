#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/virtual_scheduler.h"
#include "client/tuple_query.h"
#include "tuples/memory/memory_ecology.h"

namespace rubicon::client {

using namespace std::chrono_literals;

struct Member {
  Member(tuples::MemoryEcology& ecology, VirtualScheduler& scheduler, std::uint32_t id)
      : link(std::move(*ecology.join(OwnerId(id)))), space(OwnerId(id), scheduler, *link) {}
  std::unique_ptr<tuples::Link> link;
  TupleSpace space;
};

/// An island (1) played by hand and a component (70000), in virtual time.
struct ClientParts : testing::Test {
  static constexpr OwnerId kIsland{1};

  void describe(const std::string& device, const std::string& rest) {
    ASSERT_TRUE(island->space.set("proxy.wsn-1." + device + ".description", rest, {"application/json"}));
    ASSERT_TRUE(island->space.set("proxy.wsn-1." + device + ".status", R"({"status":"reachable"})"));
  }

  VirtualScheduler time;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<Member> island = std::make_unique<Member>(ecology, time, 1);
  Member self{ecology, time, 70000};
  PeerDiscovery peer_discovery{time, self.space, kDdsPace};
  std::vector<Tuple> found;
  int times = 0;
  TuplesCall keep = [this](std::vector<Tuple> tuples) {
    found = std::move(tuples);
    ++times;
  };
};

}  // namespace rubicon::client
