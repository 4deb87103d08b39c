#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// Publishes the island's own numbers and states as `<prefix>.property.<name>.value`: queues, drops, what the state
/// file and the recorders do. Once a second, and only what changed. While a component subscribes actively to
/// `<prefix>.property.clock.value` that says what the island's clock says, so that others can compare it with theirs.
class IslandMetrics {
 public:
  /// Publishes one number or word; names are `[a-z-]+`.
  class Publish {
   public:
    explicit Publish(std::map<std::string, std::string>& into) : into_(into) {}
    void operator()(const std::string& name, std::uint64_t value) const { into_[name] = std::to_string(value); }
    void word(const std::string& name, std::string text) const { into_[name] = std::move(text); }

   private:
    std::map<std::string, std::string>& into_;
  };
  using Source = std::function<void(const Publish& publish)>;

  IslandMetrics(Scheduler& scheduler, TupleSpace& space, std::string prefix);

  /// Asked each time; what it uses must live as long as this.
  void add(Source source) { sources_.push_back(std::move(source)); }
  void start();

 private:
  void publish();
  void publish_clock();

  Scheduler& scheduler_;
  TupleSpace& space_;
  std::string prefix_;
  std::vector<Source> sources_;
  std::map<std::string, std::string> published_;
  bool clock_wanted_ = false;
  tuples::Handle clock_watch_;
  Timer timer_;
};

}  // namespace rubicon::island
