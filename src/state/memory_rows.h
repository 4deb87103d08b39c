#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.h"
#include "sqlite/database.h"
#include "state/state_store.h"

namespace rubicon::state {

using sqlite::Database;
using sqlite::Query;
using sqlite::Statement;

/// The table of what networks remember, by network and name.
class MemoryRows {
 public:
  static Result<MemoryRows> prepare(Database& database);

  Result<void> put(std::string_view network, std::string_view name, ByteView value);
  Result<void> remove(std::string_view network, std::string_view name);
  Result<std::optional<Bytes>> find(std::string_view network, std::string_view name);
  /// The number of values that the network has under other names.
  Result<std::uint64_t> count_others(std::string_view network, std::string_view name);
  /// Of all networks that have values, by name.
  Result<std::vector<MemorySize>> sizes();
  /// False: there was none.
  Result<bool> remove_all(std::string_view network);

 private:
  MemoryRows() = default;

  Statement put_, remove_, find_, count_, sizes_, remove_all_;
};

}  // namespace rubicon::state
