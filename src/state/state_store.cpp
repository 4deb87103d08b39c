#include "state/state_store.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/assert.h"
#include "state/rows.h"
#include "state/state_file.h"

namespace rubicon::state {

namespace {

constexpr std::uint64_t kMinFileSize = 256 << 10;
/// In the file without texts, with the share of the B-tree.
constexpr std::uint64_t kBytesPerValue = 96, kBytesPerDevice = 256;
constexpr std::uint64_t kSparePages = 8;  // for pages that SQLite splits
constexpr std::size_t kMaxText = 4096;
constexpr std::size_t kMaxAddress = 255;
/// Devices that are forgotten at once to make room.
constexpr std::int64_t kMinPruned = 16, kMaxPruned = 1024;
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
                fmt::format("state: {} of device {} has {} bytes, expected at most {}", field.name,
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
                  fmt::format("state: the value of {} {}-{} has {} bytes, expected at most {}",
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
  Impl(StateFile opened, DeviceRows device_rows, ValueRows value_rows, MemoryRows memory_rows)
      : file(std::move(opened)),
        devices(std::move(device_rows)),
        values(std::move(value_rows)),
        memory(std::move(memory_rows)) {}

  StateFile file;
  DeviceRows devices;
  ValueRows values;
  MemoryRows memory;
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
  void count(const Result<void>& done);
  Result<std::uint64_t> used_pages();
  Result<void> make_room(std::uint64_t bytes, Row except);
  Result<void> prune(std::uint64_t goal, Row except);
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
  max_pages = std::max(options.max_bytes, kMinFileSize) / page_bytes;
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
  // SQLite has already done it if the disk is full.
  if (file.database.in_transaction()) std::ignore = file.database.run("ROLLBACK", "rolling back");
  stats.devices = at_begin.devices;
  stats.values = at_begin.values;
  stats.pruned = at_begin.pruned;
}

void StateStore::Impl::count(const Result<void>& done) {
  if (done) {
    ++stats.writes;
  } else {
    ++stats.failures;
  }
}

/// Does `work` in the transaction that was begun, or in one of its own.
Result<void> StateStore::Impl::transact(const std::function<Result<void>()>& work) {
  if (file.read_only) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: open for reading only", file.path));
  }
  if (begun) {
    if (broken) return fail(*broken);
    auto done = work();
    // These two change nothing but forget devices to make room.
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
  count(done);
  return done;
}

Result<std::uint64_t> StateStore::Impl::used_pages() {
  Query all(pages), unused(free_pages);
  if (const auto row = all.next(); !row) return fail(row.error());
  if (const auto row = unused.next(); !row) return fail(row.error());
  const auto used = all.integer_at(0) - unused.integer_at(0);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(used, 0));
}

/// Forgets devices until so many more bytes fit into the file.
Result<void> StateStore::Impl::make_room(std::uint64_t bytes, Row except) {
  const auto needed = bytes / page_bytes * 2 + kSparePages;
  const auto used = used_pages();
  if (!used) return fail(used.error());
  if (*used + needed <= max_pages) return {};
  const auto spare = max_pages / 64;  // so that not every write forgets devices
  if (needed + spare < max_pages) return prune(max_pages - needed - spare, except);
  return fail(ErrorCode::kBusy, fmt::format("state file {}: no room for {} bytes, its size is limited to {} bytes",
                                            file.path, bytes, max_pages * page_bytes));
}

Result<void> StateStore::Impl::prune(std::uint64_t goal, Row except) {
  while (true) {
    const auto used = used_pages();
    if (!used) return fail(used.error());
    if (*used <= goal) return {};
    const auto batch = std::clamp(static_cast<std::int64_t>(stats.devices / 64), kMinPruned, kMaxPruned);
    const auto rows = devices.stalest(except, batch);
    if (!rows) return fail(rows.error());
    if (rows->empty()) {
      return fail(ErrorCode::kBusy,
                  fmt::format("state file {}: its limit of {} bytes is reached", file.path, max_pages * page_bytes));
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
  auto memory = MemoryRows::prepare(file->database);
  if (!memory) return fail(memory.error());
  auto made = std::make_unique<Impl>(std::move(*file), std::move(*devices), std::move(*values), std::move(*memory));
  if (auto done = made->prepare(options); !done) return fail(done.error());
  return std::unique_ptr<StateStore>(new StateStore(std::move(made)));
}

Result<std::unique_ptr<StateStore>> StateStore::open(const std::string& path, IslandId island, StateOptions options) {
  RUBICON_ASSERT(model::is_island(island));
  return make(open_state_file(path, FileUse::kOwn, island, std::max(options.max_bytes, kMinFileSize)), options);
}

Result<std::unique_ptr<StateStore>> StateStore::open_existing(const std::string& path, Use use, StateOptions options) {
  const auto file_use = use == Use::kWrite ? FileUse::kOwn : FileUse::kRead;
  return make(open_state_file(path, file_use, std::nullopt, std::max(options.max_bytes, kMinFileSize)), options);
}

IslandId StateStore::island() const {
  return impl_->file.island;
}

Result<StateStore::Row> StateStore::save(const KnownDevice& device) {
  auto& impl = *impl_;
  Row row = kNoRow;
  // Checked before anything is written, so that a transaction survives a device that cannot be stored.
  if (auto fits = check_texts(device); !fits) {
    ++impl.stats.failures;
    return fail(fits.error());
  }
  const auto bytes = impl.announcements.write(device.join, device.point_ids);
  if (!bytes) {
    ++impl.stats.failures;
    return fail(ErrorCode::kOutOfRange,
                fmt::format("state: device {} cannot be stored: {}", name_of(device), bytes.error().text));
  }
  const auto values = size_of(device.values);
  if (!values) {
    ++impl.stats.failures;
    return fail(values.error());
  }
  auto done = impl.write([&]() -> Result<void> {
    const auto known = impl.devices.row_of(device.network, device.address);
    if (!known) return fail(known.error());
    row = known->value_or(kNoRow);
    const auto size = bytes->capabilities.size() + bytes->point_ids.size() + kBytesPerDevice + *values;
    if (auto room = impl.make_room(size, row); !room) return room;
    if (row != kNoRow) return impl.devices.update(row, device, *bytes);
    const auto fresh = impl.devices.insert(device, *bytes);
    if (!fresh) return fail(fresh.error());
    row = *fresh;
    ++impl.stats.devices;
    if (auto put = impl.put(row, device.values); !put) return put;
    return impl.hear(row, device.values);
  });
  if (!done) return fail(done.error());
  return row;
}

Result<void> StateStore::save_values(Row device, std::span<const StoredValue> values) {
  auto& impl = *impl_;
  const auto bytes = size_of(values);
  if (!bytes) {
    ++impl.stats.failures;
    return fail(bytes.error());
  }
  return impl.write([&]() -> Result<void> {
    const auto known = impl.devices.exists(device);
    if (!known) return fail(known.error());
    if (!*known) {
      return fail(ErrorCode::kNotFound,
                  fmt::format("state file {}: device row {} was forgotten", impl.file.path, device));
    }
    if (auto room = impl.make_room(*bytes, device); !room) return room;
    if (auto done = impl.put(device, values); !done) return done;
    return impl.hear(device, values);
  });
}

Result<void> StateStore::rename(Row device, const std::string& name, const std::string& area) {
  auto& impl = *impl_;
  if (name.size() > kMaxGiven || area.size() > kMaxGiven) {
    ++impl.stats.failures;
    return fail(ErrorCode::kOutOfRange, fmt::format("state: name or area has {} bytes, expected at most {}",
                                                    std::max(name.size(), area.size()), kMaxGiven));
  }
  return impl.write([&]() -> Result<void> {
    const auto known = impl.devices.exists(device);
    if (!known) return fail(known.error());
    if (*known) return impl.devices.rename(device, name, area);
    return fail(ErrorCode::kNotFound,
                fmt::format("state file {}: device row {} was forgotten", impl.file.path, device));
  });
}

Result<void> StateStore::forget(const std::string& network, const std::string& address) {
  auto& impl = *impl_;
  return impl.write([&]() -> Result<void> {
    const auto row = impl.devices.row_of(network, address);
    if (!row) return fail(row.error());
    if (*row) return impl.remove(**row);
    return fail(ErrorCode::kNotFound, fmt::format("state file {}: no device {}/{}", impl.file.path,
                                                  network.substr(0, kMaxAddress), address.substr(0, kMaxAddress)));
  });
}

Result<std::optional<KnownDevice>> StateStore::find(const std::string& network, const std::string& address) const {
  auto& impl = *impl_;
  const auto row = impl.devices.row_of(network, address);
  if (!row) return fail(row.error());
  if (!*row) return std::optional<KnownDevice>();
  auto device = impl.devices.read(**row, impl.stats.damaged);
  if (!device || !*device) return device;
  auto values = impl.values.of(**row, impl.stats.damaged);
  if (!values) return fail(values.error());
  (*device)->values = std::move(*values);
  return device;
}

Result<void> StateStore::each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) const {
  auto& impl = *impl_;
  return impl.devices.each(impl.file.database, network, impl.stats.damaged,
                           [&](Row row, KnownDevice&& device) -> Result<void> {
                             auto values = impl.values.of(row, impl.stats.damaged);
                             if (!values) return fail(values.error());
                             device.values = std::move(*values);
                             visit(row, std::move(device));
                             return {};
                           });
}

Result<void> StateStore::remember(const std::string& network, std::string_view name, ByteView value, std::size_t most,
                                  bool durable) {
  auto& impl = *impl_;
  RUBICON_ASSERT(!impl.begun);
  auto done = impl.write([&]() -> Result<void> {
    if (value.empty()) return impl.memory.remove(network, name);
    const auto others = impl.memory.count_others(network, name);
    if (!others) return fail(others.error());
    if (*others >= most) {
      return fail(ErrorCode::kBusy, fmt::format("state file {}: network {} remembers {} values, which are the most",
                                                impl.file.path, network.substr(0, kMaxAddress), *others));
    }
    const auto before = impl.memory.find(network, name);
    if (!before) return fail(before.error());
    if (!*before || (*before)->size() < value.size()) {
      if (auto room = impl.make_room(value.size() + kBytesPerValue, kNoRow); !room) return room;
    }
    return impl.memory.put(network, name, value);
  });
  return done && durable ? impl.file.database.sync() : done;
}

Result<std::optional<Bytes>> StateStore::remembered(const std::string& network, std::string_view name) const {
  return impl_->memory.find(network, name);
}

Result<std::vector<MemorySize>> StateStore::memories() const {
  return impl_->memory.sizes();
}

Result<void> StateStore::forget_memory(const std::string& network) {
  auto& impl = *impl_;
  return impl.write([&]() -> Result<void> {
    const auto removed = impl.memory.remove_all(network);
    if (!removed) return fail(removed.error());
    if (*removed) return {};
    return fail(ErrorCode::kNotFound, fmt::format("state file {}: network {} remembers nothing", impl.file.path,
                                                  network.substr(0, kMaxAddress)));
  });
}

Result<void> StateStore::begin() {
  auto& impl = *impl_;
  RUBICON_ASSERT(!impl.begun);
  if (impl.file.read_only) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: open for reading only", impl.file.path));
  }
  if (auto done = impl.start(); !done) return done;
  impl.begun = true;
  return {};
}

Result<void> StateStore::commit(bool durable) {
  auto& impl = *impl_;
  RUBICON_ASSERT(impl.begun);
  impl.begun = false;
  auto done = impl.broken ? Result<void>(fail(*impl.broken)) : impl.finish();
  if (!done) {
    impl.undo();
  } else if (durable) {
    done = impl.file.database.sync();
  }
  impl.count(done);
  return done;
}

void StateStore::rollback() {
  RUBICON_ASSERT(impl_->begun);
  impl_->begun = false;
  impl_->undo();
}

Result<void> StateStore::tidy() {
  auto& impl = *impl_;
  RUBICON_ASSERT(!impl.begun);
  if (impl.file.read_only) return {};
  return impl.file.database.run("PRAGMA wal_checkpoint(PASSIVE)", "moving its log into it");
}

StateStore::Stats StateStore::stats() const {
  auto& impl = *impl_;
  auto stats = impl.stats;
  Query all(impl.pages);
  if (const auto row = all.next(); row && *row) {
    stats.bytes = static_cast<std::uint64_t>(all.integer_at(0)) * impl.page_bytes;
  }
  return stats;
}

}  // namespace rubicon::state
