#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/bytes.h"
#include "model/message.h"
#include "rubicon/result.hpp"
#include "sqlite/database.h"
#include "state/state_store.h"

namespace rubicon::state {

using PointIds = std::vector<std::pair<model::PointId, std::string>>;

/// An announcement in the CBOR of docs/gateway.cddl: a Join without name and id, which have columns of their own, and
/// the ids of the points in keys as values of an Updates. Devices of the same kind have the same bytes.
struct AnnouncementBytes {
  Bytes capabilities;
  Bytes point_ids;
};

/// Encodes announcements; refuses those that could not be read back.
class AnnouncementWriter {
 public:
  /// kOutOfRange or kInvalid: it exceeds the limits of the encoding; the text names the field.
  Result<AnnouncementBytes> write(const model::Join& join, const PointIds& point_ids);

 private:
  Result<void> check(const Bytes& bytes);

  std::unordered_set<std::string> sound_;  ///< already checked; bounded
  std::size_t sound_bytes_ = 0;
};

/// Decodes announcements, equal ones only once.
class AnnouncementReader {
 public:
  /// nullptr: the bytes are no announcement. The result is valid until the next call.
  const model::Join* join(ByteView bytes);
  const PointIds* point_ids(ByteView bytes);

 private:
  std::unordered_map<std::string, model::Join> joins_;
  std::unordered_map<std::string, PointIds> point_ids_;
};

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
