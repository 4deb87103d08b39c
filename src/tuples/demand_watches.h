#pragma once

#include "tuples/store.h"

namespace rubicon::tuples {

/// Reports changes of the demand for own tuples to watches, merged per turn.
class DemandWatches {
 public:
  struct Watch {
    Pattern pattern;
    DemandCall call;
    bool alive = true;
    bool is_new = true;  ///< the present demand has not been reported to it yet
  };

  DemandWatches(Store& store, OwnerId self) : store_(store), self_(self) {}

  std::shared_ptr<Watch> add(const Pattern& pattern, DemandCall call);
  void remove(const std::shared_ptr<Watch>& watch);

  /// The demand for an own tuple may have changed from `before`.
  void note(std::uint32_t index, const DemandState& before);
  bool pending() const { return !order_.empty() || any_new_; }
  void drain();

 private:
  void report_change(std::uint32_t index, const DemandState& before);
  void report_present(Watch& watch);
  void report(Watch& watch, std::uint32_t index, const DemandState& demand);
  DemandState demand_of(std::uint32_t index) const;

  Store& store_;
  OwnerId self_;
  std::vector<std::shared_ptr<Watch>> watches_;
  std::unordered_map<std::uint32_t, DemandState> before_;
  std::vector<std::uint32_t> order_;
  bool any_new_ = false;
};

}  // namespace rubicon::tuples
