#include "state/memory_rows.h"

#include <utility>

namespace rubicon::state {

Result<MemoryRows> MemoryRows::prepare(Database& database) {
  MemoryRows rows;
  const auto make = [&database](Statement& into, const char* sql, const char* doing) -> Result<void> {
    auto statement = database.prepare(sql, doing);
    if (!statement) return fail(statement.error());
    into = std::move(*statement);
    return {};
  };
  constexpr const char* kWriting = "writing what a network remembers";
  constexpr const char* kReading = "reading what a network remembers";
  if (auto done = make(rows.put_, "INSERT OR REPLACE INTO memory(network,name,value) VALUES(?,?,?)", kWriting); !done)
    return fail(done.error());
  if (auto done = make(rows.remove_, "DELETE FROM memory WHERE network=? AND name=?", kWriting); !done)
    return fail(done.error());
  if (auto done = make(rows.find_, "SELECT value FROM memory WHERE network=? AND name=?", kReading); !done)
    return fail(done.error());
  if (auto done = make(rows.count_, "SELECT count(*) FROM memory WHERE network=? AND name<>?", kReading); !done)
    return fail(done.error());
  if (auto done =
          make(rows.sizes_, "SELECT network,count(*),sum(length(value)) FROM memory GROUP BY network ORDER BY network",
               kReading);
      !done)
    return fail(done.error());
  if (auto done = make(rows.remove_all_, "DELETE FROM memory WHERE network=?", kWriting); !done)
    return fail(done.error());
  return rows;
}

Result<void> MemoryRows::put(std::string_view network, std::string_view name, ByteView value) {
  Query query(put_);
  return query.text(network).text(name).blob(value).run();
}

Result<void> MemoryRows::remove(std::string_view network, std::string_view name) {
  Query query(remove_);
  return query.text(network).text(name).run();
}

Result<std::optional<Bytes>> MemoryRows::find(std::string_view network, std::string_view name) {
  Query query(find_);
  const auto row = query.text(network).text(name).next();
  if (!row) return fail(row.error());
  if (!*row) return std::optional<Bytes>();
  const auto value = query.blob_at(0);
  return Bytes(value.begin(), value.end());
}

Result<std::uint64_t> MemoryRows::count_others(std::string_view network, std::string_view name) {
  Query query(count_);
  const auto row = query.text(network).text(name).next();
  if (!row) return fail(row.error());
  return static_cast<std::uint64_t>(query.integer_at(0));
}

Result<std::vector<MemorySize>> MemoryRows::sizes() {
  std::vector<MemorySize> all;
  Query query(sizes_);
  while (true) {
    const auto row = query.next();
    if (!row) return fail(row.error());
    if (!*row) return all;
    all.push_back({std::string(query.text_at(0)), static_cast<std::uint64_t>(query.integer_at(1)),
                   static_cast<std::uint64_t>(query.integer_at(2))});
  }
}

Result<bool> MemoryRows::remove_all(std::string_view network) {
  Query query(remove_all_);
  if (auto done = query.text(network).run(); !done) return fail(done.error());
  return query.changes() > 0;
}

}  // namespace rubicon::state
