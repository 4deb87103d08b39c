#include "state/state_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"
#include "state/device_rows.h"
#include "state/state_file.h"
#include "state/value_rows.h"

namespace rubicon::state {

namespace {

constexpr std::uint64_t kSmallestBound = 256 << 10;
constexpr std::uint64_t kBytesPerValue = 96;    // of a row and its part of the tree, without texts
constexpr std::uint64_t kBytesPerDevice = 256;  // same
constexpr std::uint64_t kSparePages = 8;        // for what splits of pages take
constexpr std::size_t kMaxText = 4096;
constexpr std::size_t kMaxAddress = 255;
constexpr std::int64_t kFewestPruned = 16, kMostPruned = 1024;
constexpr StateStore::Row kNoRow = 0;  // rows count from 1

std::string name_of(const KnownDevice& device) {
  return fmt::format("{}/{}", device.network, device.address);
}

Result<void> check_texts(const KnownDevice& device) {
  struct Field {
    const char* name;
    const std::string& text;
    std::size_t most;
  };
  for (const auto& field :
       {Field{"network", device.network, kMaxAddress}, Field{"address", device.address, kMaxAddress},
        Field{"id", device.id, kMaxAddress}, Field{"join.id", device.join.id, kMaxAddress},
        Field{"join.name", device.join.name, kMaxText}, Field{"given name", device.given_name, kMaxGiven},
        Field{"area", device.area, kMaxGiven}}) {
    if (field.text.size() <= field.most) continue;
    return fail(ErrorCode::kOutOfRange,
                fmt::format("state: {} of device {}: {} bytes, at most {} are kept", field.name,
                            name_of(device).substr(0, kMaxAddress), field.text.size(), field.most));
  }
  return {};
}

Result<std::uint64_t> size_of(std::span<const StoredValue> values) {
  std::uint64_t bytes = 0;
  for (const auto& value : values) {
    const auto size = ValueRows::size_of(value);
    if (size > kMaxStoredValue) {
      return fail(ErrorCode::kOutOfRange,
                  fmt::format("state: the value of {} {}-{} has {} bytes, at most {} are kept",
                              to_string(value.point.kind), static_cast<unsigned>(value.point.type),
                              value.point.instance.substr(0, 60), size, kMaxStoredValue));
    }
    bytes += size + kBytesPerValue;
  }
  return bytes;
}

}  // namespace

std::string_view to_string(Decision decision) {
  switch (decision) {
    case Decision::kNone: return "none";
    case Decision::kApproved: return "approved";
    case Decision::kIgnored: return "ignored";
  }
  return "none";
}

struct StateStore::Impl {
  Impl(StateFile opened, DeviceRows device_rows, ValueRows value_rows)
      : file(std::move(opened)), devices(std::move(device_rows)), values(std::move(value_rows)) {}

  StateFile file;
  DeviceRows devices;
  ValueRows values;
  Statement pages, free_pages;
  std::uint64_t page_bytes = 4096, max_pages = 0;
  AnnouncementWriter announcements;
  Stats stats, at_begin;
  bool begun = false;
  std::optional<Error> broken;  ///< why the transaction cannot be committed

  Result<void> prepare(const StateOptions& options);
  Result<void> transact(const std::function<Result<void>()>& work);
  Result<void> write(const std::function<Result<void>()>& work);
  Result<void> start();
  Result<void> finish();
  void undo();
  Result<std::uint64_t> used_pages();
  Result<void> make_room(std::uint64_t bytes, Row but);
  Result<void> prune(std::uint64_t goal, Row but);
  Result<void> remove(Row row);
  Result<void> put(Row row, std::span<const StoredValue> of_device);
  Result<void> hear(Row row, std::span<const StoredValue> of_device);
};

Result<void> StateStore::Impl::prepare(const StateOptions& options) {
  auto& database = file.database;
  auto all_pages = database.prepare("PRAGMA page_count", "measuring");
  auto unused_pages = database.prepare("PRAGMA freelist_count", "measuring");
  const auto page_size = database.number("PRAGMA page_size", "measuring");
  if (!all_pages) return fail(all_pages.error());
  if (!unused_pages) return fail(unused_pages.error());
  if (!page_size) return fail(page_size.error());
  pages = std::move(*all_pages);
  free_pages = std::move(*unused_pages);
  page_bytes = static_cast<std::uint64_t>(*page_size);
  max_pages = std::max(options.max_bytes, kSmallestBound) / page_bytes;
  const auto known = devices.count();
  if (!known) return fail(known.error());
  const auto kept = values.count();
  if (!kept) return fail(kept.error());
  stats.devices = *known;
  stats.values = *kept;
  stats.read_only = file.read_only;
  return {};
}

Result<void> StateStore::Impl::start() {
  at_begin = stats;
  broken.reset();
  return file.database.run("BEGIN IMMEDIATE", "beginning to write");
}

Result<void> StateStore::Impl::finish() {
  return file.database.run("COMMIT", "writing");
}

void StateStore::Impl::undo() {
  // SQLite may have done so itself, when the disk was full.
  if (file.database.in_transaction()) std::ignore = file.database.run("ROLLBACK", "rolling back");
  stats.devices = at_begin.devices;
  stats.values = at_begin.values;
  stats.pruned = at_begin.pruned;
}

/// Does `work` in the transaction that was begun, or in one of its own.
Result<void> StateStore::Impl::transact(const std::function<Result<void>()>& work) {
  if (file.read_only) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: open for reading only", file.path));
  }
  if (begun) {
    if (broken) return fail(*broken);
    auto done = work();
    // Found out before the first change, or after devices were forgotten to make room.
    const bool harmless = done || done.error().code == ErrorCode::kNotFound || done.error().code == ErrorCode::kBusy;
    if (!harmless) broken = done.error();
    return done;
  }
  if (auto done = start(); !done) return done;
  auto done = work();
  if (done) done = finish();
  if (!done) undo();
  return done;
}

Result<void> StateStore::Impl::write(const std::function<Result<void>()>& work) {
  auto done = transact(work);
  ++(done ? stats.writes : stats.failures);
  return done;
}

Result<std::uint64_t> StateStore::Impl::used_pages() {
  Query all(pages), unused(free_pages);
  if (const auto row = all.next(); !row) return fail(row.error());
  if (const auto row = unused.next(); !row) return fail(row.error());
  const auto used = all.integer_at(0) - unused.integer_at(0);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(used, 0));
}

/// Forgets devices until so many bytes more fit below the bound.
Result<void> StateStore::Impl::make_room(std::uint64_t bytes, Row but) {
  const auto needed = bytes / page_bytes * 2 + kSparePages;
  const auto used = used_pages();
  if (!used) return fail(used.error());
  if (*used + needed <= max_pages) return {};
  const auto spare = max_pages / 64;  // so that not every write has to
  if (needed + spare < max_pages) return prune(max_pages - needed - spare, but);
  return fail(ErrorCode::kBusy, fmt::format("state file {}: {} bytes do not fit below its bound of {} bytes", file.path,
                                            bytes, max_pages * page_bytes));
}

Result<void> StateStore::Impl::prune(std::uint64_t goal, Row but) {
  while (true) {
    const auto used = used_pages();
    if (!used) return fail(used.error());
    if (*used <= goal) return {};
    const auto batch = std::clamp(static_cast<std::int64_t>(stats.devices / 64), kFewestPruned, kMostPruned);
    const auto rows = devices.stalest(but, batch);
    if (!rows) return fail(rows.error());
    if (rows->empty()) {
      return fail(ErrorCode::kBusy,
                  fmt::format("state file {}: its bound of {} bytes is reached", file.path, max_pages * page_bytes));
    }
    for (const auto row : *rows) {
      if (auto done = remove(row); !done) return done;
      ++stats.pruned;
    }
  }
}

Result<void> StateStore::Impl::remove(Row row) {
  const auto gone = values.remove(row);
  if (!gone) return fail(gone.error());
  if (auto done = devices.remove(row); !done) return done;
  stats.values -= std::min(stats.values, *gone);
  stats.devices -= std::min<std::uint64_t>(stats.devices, 1);
  return {};
}

Result<void> StateStore::Impl::put(Row row, std::span<const StoredValue> of_device) {
  for (const auto& value : of_device) {
    const auto fresh = values.put(row, value);
    if (!fresh) return fail(fresh.error());
    if (*fresh) ++stats.values;
  }
  return {};
}

Result<void> StateStore::Impl::hear(Row row, std::span<const StoredValue> of_device) {
  WallTime latest{};
  for (const auto& value : of_device) latest = std::max(latest, value.heard);
  return latest == WallTime{} ? Result<void>() : devices.hear(row, latest);
}

StateStore::StateStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

StateStore::~StateStore() = default;

Result<std::unique_ptr<StateStore>> StateStore::make(Result<StateFile> file, const StateOptions& options) {
  if (!file) return fail(file.error());
  auto devices = DeviceRows::prepare(file->database);
  if (!devices) return fail(devices.error());
  auto values = ValueRows::prepare(file->database);
  if (!values) return fail(values.error());
  auto parts = std::make_unique<Impl>(std::move(*file), std::move(*devices), std::move(*values));
  if (auto done = parts->prepare(options); !done) return fail(done.error());
  return std::unique_ptr<StateStore>(new StateStore(std::move(parts)));
}

Result<std::unique_ptr<StateStore>> StateStore::open(const std::string& path, IslandId island, StateOptions options) {
  RUBICON_ASSERT(model::is_island(island));
  return make(open_state_file(path, FileUse::kOwn, island, std::max(options.max_bytes, kSmallestBound)), options);
}

Result<std::unique_ptr<StateStore>> StateStore::open_existing(const std::string& path, Use use, StateOptions options) {
  const auto file_use = use == Use::kWrite ? FileUse::kOwn : FileUse::kRead;
  return make(open_state_file(path, file_use, std::nullopt, std::max(options.max_bytes, kSmallestBound)), options);
}

IslandId StateStore::island() const {
  return impl_->file.island;
}

Result<StateStore::Row> StateStore::save(const KnownDevice& device) {
  auto& parts = *impl_;
  Row row = kNoRow;
  // Before anything is written: a transaction survives a device that does not fit the form.
  auto fits = check_texts(device);
  if (!fits) return ++parts.stats.failures, fail(fits.error());
  const auto bytes = parts.announcements.write(device.join, device.point_ids);
  if (!bytes) {
    ++parts.stats.failures;
    return fail(ErrorCode::kOutOfRange,
                fmt::format("state: device {} cannot be kept: {}", name_of(device), bytes.error().text));
  }
  const auto values = size_of(device.values);
  if (!values) return ++parts.stats.failures, fail(values.error());
  auto done = parts.write([&]() -> Result<void> {
    const auto known = parts.devices.row_of(device.network, device.address);
    if (!known) return fail(known.error());
    row = known->value_or(kNoRow);
    const auto size = bytes->capabilities.size() + bytes->point_ids.size() + kBytesPerDevice + *values;
    if (auto room = parts.make_room(size, row); !room) return room;
    if (row != kNoRow) return parts.devices.update(row, device, *bytes);
    const auto fresh = parts.devices.insert(device, *bytes);
    if (!fresh) return fail(fresh.error());
    row = *fresh;
    ++parts.stats.devices;
    if (auto put = parts.put(row, device.values); !put) return put;
    return parts.hear(row, device.values);
  });
  if (!done) return fail(done.error());
  return row;
}

Result<void> StateStore::save_values(Row device, std::span<const StoredValue> values) {
  auto& parts = *impl_;
  const auto bytes = size_of(values);
  if (!bytes) return ++parts.stats.failures, fail(bytes.error());
  return parts.write([&]() -> Result<void> {
    const auto known = parts.devices.exists(device);
    if (!known) return fail(known.error());
    if (!*known) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("state file {}: device row {} was forgotten", parts.file.path, device));
    }
    if (auto room = parts.make_room(*bytes, device); !room) return room;
    if (auto done = parts.put(device, values); !done) return done;
    return parts.hear(device, values);
  });
}

Result<void> StateStore::rename(Row device, const std::string& name, const std::string& area) {
  auto& parts = *impl_;
  if (name.size() > kMaxGiven || area.size() > kMaxGiven) {
    ++parts.stats.failures;
    return fail(ErrorCode::kOutOfRange, fmt::format("state: name or area of {} bytes, at most {} are kept",
                                                    std::max(name.size(), area.size()), kMaxGiven));
  }
  return parts.write([&]() -> Result<void> {
    const auto known = parts.devices.exists(device);
    if (!known) return fail(known.error());
    if (*known) return parts.devices.rename(device, name, area);
    return fail(ErrorCode::kNotFound,
                fmt::format("state file {}: device row {} was forgotten", parts.file.path, device));
  });
}

Result<void> StateStore::forget(const std::string& network, const std::string& address) {
  auto& parts = *impl_;
  return parts.write([&]() -> Result<void> {
    const auto row = parts.devices.row_of(network, address);
    if (!row) return fail(row.error());
    if (*row) return parts.remove(**row);
    return fail(ErrorCode::kNotFound, fmt::format("state file {}: no device {}/{}", parts.file.path,
                                                  network.substr(0, kMaxAddress), address.substr(0, kMaxAddress)));
  });
}

Result<std::optional<KnownDevice>> StateStore::find(const std::string& network, const std::string& address) const {
  auto& parts = *impl_;
  const auto row = parts.devices.row_of(network, address);
  if (!row) return fail(row.error());
  if (!*row) return std::optional<KnownDevice>();
  auto device = parts.devices.read(**row, parts.stats.damaged);
  if (!device || !*device) return device;
  auto values = parts.values.of(**row, parts.stats.damaged);
  if (!values) return fail(values.error());
  (*device)->values = std::move(*values);
  return device;
}

Result<void> StateStore::each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) const {
  auto& parts = *impl_;
  return parts.devices.each(parts.file.database, network, parts.stats.damaged,
                            [&](Row row, KnownDevice&& device) -> Result<void> {
                              auto values = parts.values.of(row, parts.stats.damaged);
                              if (!values) return fail(values.error());
                              device.values = std::move(*values);
                              visit(row, std::move(device));
                              return {};
                            });
}

Result<void> StateStore::begin() {
  auto& parts = *impl_;
  RUBICON_ASSERT(!parts.begun);
  if (parts.file.read_only) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: open for reading only", parts.file.path));
  }
  if (auto done = parts.start(); !done) return done;
  parts.begun = true;
  return {};
}

Result<void> StateStore::commit(bool durable) {
  auto& parts = *impl_;
  RUBICON_ASSERT(parts.begun);
  parts.begun = false;
  auto done = parts.broken ? Result<void>(fail(*parts.broken)) : parts.finish();
  if (!done) {
    parts.undo();
  } else if (durable) {
    done = parts.file.database.sync();
  }
  ++(done ? parts.stats.writes : parts.stats.failures);
  return done;
}

void StateStore::rollback() {
  RUBICON_ASSERT(impl_->begun);
  impl_->begun = false;
  impl_->undo();
}

Result<void> StateStore::tidy() {
  auto& parts = *impl_;
  RUBICON_ASSERT(!parts.begun);
  if (parts.file.read_only) return {};
  return parts.file.database.run("PRAGMA wal_checkpoint(PASSIVE)", "moving its log into it");
}

StateStore::Stats StateStore::stats() const {
  auto& parts = *impl_;
  auto stats = parts.stats;
  Query all(parts.pages);
  if (const auto row = all.next(); row && *row) {
    stats.bytes = static_cast<std::uint64_t>(all.integer_at(0)) * parts.page_bytes;
  }
  return stats;
}

}  // namespace rubicon::state
