#pragma once

#include <cstdint>
#include <vector>

#include "state/sqlite.h"
#include "state/state_store.h"

namespace rubicon::state {

/// The table of last values.
class ValueRows {
 public:
  static Result<ValueRows> prepare(Database& database);

  /// True: it was not there before.
  Result<bool> put(StateStore::Row device, const StoredValue& value);
  /// How many went.
  Result<std::uint64_t> remove(StateStore::Row device);
  /// Sound ones by kind, type and instance; `damaged` grows by the others.
  Result<std::vector<StoredValue>> of(StateStore::Row device, std::uint64_t& damaged);
  Result<std::uint64_t> count();

  /// Bytes of text that the value brings into the file.
  static std::size_t size_of(const StoredValue& value);

 private:
  ValueRows() = default;

  Statement update_, insert_, remove_, select_, count_;
};

}  // namespace rubicon::state
