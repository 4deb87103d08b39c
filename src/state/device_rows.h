#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sqlite/database.h"
#include "state/announcement.h"
#include "state/state_store.h"

namespace rubicon::state {

using sqlite::Database;
using sqlite::Query;
using sqlite::Statement;

/// The tables of devices and their announcements, without values.
class DeviceRows {
 public:
  using Row = StateStore::Row;

  static Result<DeviceRows> prepare(Database& database);

  Result<std::optional<Row>> row_of(const std::string& network, const std::string& address);
  Result<bool> exists(Row row);
  Result<Row> insert(const KnownDevice& device, const AnnouncementBytes& announcement);
  Result<void> update(Row row, const KnownDevice& device, const AnnouncementBytes& announcement);
  Result<void> rename(Row row, const std::string& name, const std::string& area);
  /// Updates last_heard if `heard` is later.
  Result<void> hear(Row row, WallTime heard);
  Result<void> remove(Row row);
  /// The devices to forget first: those without a decision and a given name before others, then by last heard.
  Result<std::vector<Row>> stalest(Row except, std::int64_t count);
  Result<std::uint64_t> count();

  /// Visits the devices that can be read, by row, up to the present last one, until `visit` returns an error. Adds the
  /// number of the others to `damaged`.
  Result<void> each(Database& database, const std::string& network, std::uint64_t& damaged,
                    const std::function<Result<void>(Row, KnownDevice&&)>& visit) const;
  Result<std::optional<KnownDevice>> read(Row row, std::uint64_t& damaged);

 private:
  DeviceRows() = default;

  Statement row_of_, exists_, insert_, rename_, insert_announcement_, update_, update_announcement_, hear_, remove_,
      remove_announcement_, stalest_, count_, read_;
};

}  // namespace rubicon::state
