#pragma once

#include <optional>
#include <string_view>

#include "base/bytes.h"
#include "sqlite/database.h"

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

 private:
  MemoryRows() = default;

  Statement put_, remove_, find_, count_;
};

}  // namespace rubicon::state
