#include "rubicon/tuple.hpp"

#include "base/assert.h"

namespace rubicon::tuples {

std::string_view to_string(EventKind kind) {
  switch (kind) {
    case EventKind::kSet: return "set";
    case EventKind::kDeleted: return "deleted";
    case EventKind::kExpired: return "expired";
    case EventKind::kLost: return "lost";
  }
  base::assertion_failed("EventKind in range", __FILE__, __LINE__);
}

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kApplied: return "applied";
    case Verdict::kRefused: return "refused";
    case Verdict::kExpired: return "expired";
    case Verdict::kNoSuchOwner: return "no-such-owner";
    case Verdict::kTimedOut: return "timed-out";
  }
  base::assertion_failed("Verdict in range", __FILE__, __LINE__);
}

}  // namespace rubicon::tuples
