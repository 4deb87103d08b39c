#pragma once

#include <string>
#include <string_view>

#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"

namespace rubicon::island {

/// What people arranged on the overview of the page, as the tuple `<prefix>.overview` (docs/tuple-keys.md), so that
/// each browser and the command line see the same: JSON {rooms: their order, pins: keys of points, names: what people
/// call points}. A set has the members that change. The state file keeps it; without one every set is refused.
class Overview {
 public:
  /// Bytes of the tuple, and of each text in it.
  static constexpr std::size_t kMaxBytes = 65536, kMaxText = 256;

  /// `store` may be nullptr; both must outlive this.
  Overview(TupleSpace& space, const std::string& prefix, state::StateStore* store);

 private:
  tuples::SetDecision decide(std::string_view text);
  void show();

  TupleSpace& space_;
  const std::string key_;
  state::StateStore* const store_;
  std::string text_;
  tuples::Handle policy_;
};

}  // namespace rubicon::island
