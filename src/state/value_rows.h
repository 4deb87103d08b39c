#pragma once

#include <cstdint>
#include <vector>

#include "sqlite/database.h"
#include "state/state_store.h"

namespace rubicon::state {

using sqlite::Database;
using sqlite::Query;
using sqlite::Statement;

/// The table of last values.
class ValueRows {
 public:
  static Result<ValueRows> prepare(Database& database);

  /// True: the value is new.
  Result<bool> put(StateStore::Row device, const StoredValue& value);
  /// Returns the number of removed values.
  Result<std::uint64_t> remove(StateStore::Row device);
  /// The values that can be read, by kind, type and instance; adds the number of the others to `damaged`.
  Result<std::vector<StoredValue>> of(StateStore::Row device, std::uint64_t& damaged);
  Result<std::uint64_t> count();

  /// Bytes of text in the value.
  static std::size_t size_of(const StoredValue& value);

 private:
  ValueRows() = default;

  Statement update_, insert_, remove_, select_, count_;
};

}  // namespace rubicon::state
