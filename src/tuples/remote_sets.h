#pragma once

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "tuples/tuple_space.h"

namespace rubicon::tuples {

/// Remote sets of ours that wait for their answer; each is answered once, at the latest when its time to live ends.
class Requests {
 public:
  static constexpr std::size_t kMost = 100'000;

  Requests(OwnerId self, Scheduler& scheduler);

  bool full() const { return open_.size() >= kMost; }
  std::uint64_t next_number() { return ++last_; }
  void open(std::uint64_t request, Duration time_to_live, ReplyCall call);
  /// What remains of a request's time; nothing when it is answered already.
  std::optional<Duration> remaining(std::uint64_t request) const;
  void answer(const Reply& reply);

 private:
  struct Open {
    ReplyCall call;
    SteadyTime ends;
    Timer timer;
  };
  OwnerId self_;
  Scheduler& scheduler_;
  std::unordered_map<std::uint64_t, Open> open_;
  std::uint64_t last_ = 0;
};

/// Who decides about remote sets on our tuples.
class Judges {
 public:
  struct Seat {
    Pattern pattern;
    Judge judge;
    Accepts accepts;
  };
  std::shared_ptr<Seat> add(const Pattern& pattern, Judge judge, Accepts accepts);
  void remove(const std::shared_ptr<Seat>& seat) { std::erase(seats_, seat); }
  /// The narrowest that matches; the earlier one of equals.
  std::shared_ptr<Seat> find(OwnerId self, std::string_view key) const;

 private:
  std::vector<std::shared_ptr<Seat>> seats_;  // narrowest first
};

}  // namespace rubicon::tuples
