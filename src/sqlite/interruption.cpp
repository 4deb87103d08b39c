#include "sqlite/interruption.h"

#include <utility>

namespace rubicon::sqlite {

Interruption::Interruption(Database& database, Ends ends, std::stop_token stop, int steps)
    : database_(database.handle()), ends_(std::move(ends)), stop_(std::move(stop)) {
  if (!ends_ && !stop_.stop_possible()) return;
  // SQLite forgets an interrupt that comes before a statement begins: each one asks at its begin, too.
  const auto ask = [](void* self) {
    const auto& one = *static_cast<Interruption*>(self);
    return one.stop_.stop_requested() || (one.ends_ && one.ends_()) ? 1 : 0;
  };
  sqlite3_progress_handler(database_, steps, ask, this);
  on_stop_.emplace(stop_, Interrupt{database_});
}

Interruption::~Interruption() {
  on_stop_.reset();
  sqlite3_progress_handler(database_, 0, nullptr, nullptr);
}

}  // namespace rubicon::sqlite
