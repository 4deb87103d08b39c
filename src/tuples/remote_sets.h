#pragma once

#include <map>
#include <memory>
#include <unordered_map>
#include <vector>

#include "base/scheduler.h"
#include "rubicon/tuple_space.hpp"

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
class SetPolicies {
 public:
  struct PolicyEntry {
    Pattern pattern;
    SetPolicy policy;
    PolicyScope scope;
  };
  std::shared_ptr<PolicyEntry> add(const Pattern& pattern, SetPolicy policy, PolicyScope scope);
  void remove(const std::shared_ptr<PolicyEntry>& entry) { std::erase(entries_, entry); }
  /// The narrowest that matches; the earlier one of equals.
  std::shared_ptr<PolicyEntry> find(OwnerId self, std::string_view key) const;

 private:
  std::vector<std::shared_ptr<PolicyEntry>> entries_;  // narrowest first
};

}  // namespace rubicon::tuples
