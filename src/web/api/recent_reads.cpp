#include "web/api/recent_reads.h"

namespace rubicon::web::api {

void RecentReads::keep(const Pattern& pattern) {
  const auto name = to_string(pattern);
  auto& kept = kept_[name];
  if (!kept.subscription) kept.subscription = space_.subscribe(pattern, {.passive = true}, [](const tuples::Event&) {});
  kept.end = scheduler_.after(kTime, [this, name] { kept_.erase(name); });
}

}  // namespace rubicon::web::api
