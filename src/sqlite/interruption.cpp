#include "sqlite/interruption.h"

#include <utility>

namespace rubicon::sqlite {

Interruption::Interruption(Database& database, Ends ends) : database_(database.handle()), ends_(std::move(ends)) {
  if (!ends_) return;
  const auto ask = [](void* self) { return static_cast<Interruption*>(self)->ends_() ? 1 : 0; };
  sqlite3_progress_handler(database_, kSteps, ask, this);
}

Interruption::~Interruption() {
  sqlite3_progress_handler(database_, 0, nullptr, nullptr);
}

}  // namespace rubicon::sqlite
