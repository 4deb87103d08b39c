#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "rubicon/tuple_space.hpp"
#include "tuples/link.h"
#include "tuples/test_ecology.h"

namespace rubicon::tuples {

/// One member of an ecology in virtual time.
struct Component {
  template <class Ecology>
  Component(Ecology& ecology, VirtualScheduler& scheduler, std::uint32_t id)
      : link(std::move(*ecology.join(OwnerId(id)))), space(OwnerId(id), scheduler, *link) {
    if (!kMeetAtOnce) scheduler.run_ready();
  }
  std::unique_ptr<Link> link;
  TupleSpace space;
};

inline Pattern pattern(std::string_view text) {
  return *Pattern::parse(text);
}

/// Writes down events as `key=value` for sets, `key deleted` and `key expired`.
struct Listener {
  EventCall call() {
    return [this](const Event& event) {
      const std::string key(event.tuple.key);
      seen.push_back(event.kind == EventKind::kSet ? key + "=" + std::string(event.tuple.value)
                                                   : key + " " + std::string(to_string(event.kind)));
    };
  }
  std::vector<std::string> take() { return std::exchange(seen, {}); }
  std::vector<std::string> seen;
};
using Seen = std::vector<std::string>;

/// An island (1) and a robot (70000) that reach each other.
template <class Ecology>
struct TwoComponentsOf {
  VirtualScheduler time;
  Ecology ecology{time};
  std::unique_ptr<Component> island = std::make_unique<Component>(ecology, time, 1);
  std::unique_ptr<Component> robot = std::make_unique<Component>(ecology, time, 70000);
  static constexpr OwnerId kIsland{1};
  static constexpr OwnerId kRobot{70000};
};
using TwoComponents = TwoComponentsOf<TestEcology>;

}  // namespace rubicon::tuples
