#pragma once

#include "tuples/store.h"

namespace rubicon::tuples {

/// Tells watches which own tuples begin or cease to be wanted, merged per turn.
class DemandWatches {
 public:
  struct Watch {
    Pattern pattern;
    DemandCall call;
    bool alive = true;
    bool fresh = true;  ///< not yet told what is wanted now
  };

  DemandWatches(Store& store, OwnerId self) : store_(store), self_(self) {}

  std::shared_ptr<Watch> add(const Pattern& pattern, DemandCall call);
  void remove(const std::shared_ptr<Watch>& watch);

  /// The want of an own tuple may have changed; `before` is what it was.
  void note(std::uint32_t index, const Want& before);
  bool pending() const { return !order_.empty() || any_fresh_; }
  void drain();

 private:
  void tell_change(std::uint32_t index, const Want& before);
  void tell_present(Watch& watch);
  void tell(Watch& watch, std::uint32_t index, const Want& want);
  Want want_of(std::uint32_t index) const;

  Store& store_;
  OwnerId self_;
  std::vector<std::shared_ptr<Watch>> watches_;
  std::unordered_map<std::uint32_t, Want> before_;
  std::vector<std::uint32_t> order_;
  bool any_fresh_ = false;
};

}  // namespace rubicon::tuples
