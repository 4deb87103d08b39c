#include "proxy/memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::proxy {

namespace {

using state::Decision;
using state::KnownDevice;
using state::StoredValue;

constexpr Duration kRecordDelay = std::chrono::seconds(1);
/// The shortest time between two durable writes.
constexpr Duration kDurablePause = std::chrono::milliseconds(100);
/// Devices written in one turn of the loop.
constexpr std::size_t kRowsATurn = 200;
constexpr Duration kTidyPause = std::chrono::minutes(1);
/// Names given in a second: the loop waits for the disk at each.
constexpr int kMaxNames = 20;

/// By a user.
bool is_named(const KnownDevice& device) {
  return !device.given_name.empty() || !device.area.empty();
}

}  // namespace

model::Join announcement(const Device& device) {
  model::Join join{device.type, device.announced_name, device.model, {}, true, device.wanted_id.text()};
  for (const auto& point : device.points) {
    if (!point.storage.declared) continue;
    join.capabilities.push_back(*point.details->capability);
    join.capabilities.back().initial = std::monostate();
  }
  return join;
}

bool is_announcement(const model::Join& known, const model::Join& join) {
  return known.name == join.name &&
         std::equal(known.capabilities.begin(), known.capabilities.end(), join.capabilities.begin(),
                    join.capabilities.end(), [](const Capability& one, Capability other) {
                      other.initial = one.initial;
                      return one == other;
                    });
}

Memory::Memory(ProxyContext& context, DeviceDirectory& directory, state::StateStore* store)
    : context_(context),
      directory_(directory),
      store_(store),
      writable_(store && !store->stats().read_only),
      next_flush_(context.scheduler, [this] { flush(); }) {}

Memory::~Memory() {
  while (writable_ && (!dirty_.empty() || !unlisted_.empty())) {
    const auto before = dirty_.size() + unlisted_.size();
    flush();
    if (dirty_.size() + unlisted_.size() >= before) return;  // the file cannot be written
  }
}

std::optional<KnownDevice> Memory::recall(const std::string& network, const std::string& address) {
  if (!store_) return std::nullopt;
  const auto unwritten = unlisted_.find({network, address});
  if (unwritten != unlisted_.end() && !unwritten->second) return std::nullopt;
  auto found = store_->find(network, address);
  if (unwritten != unlisted_.end()) {
    auto known = *unwritten->second;
    if (found && *found) {
      known.values = std::move((*found)->values);
      known.given_name = std::move((*found)->given_name);
      known.area = std::move((*found)->area);
    }
    return known;
  }
  if (found) return std::move(*found);
  context_.warn("state", fmt::format("cannot recall {} on {}: {}", address, network, found.error().text));
  return std::nullopt;
}

void Memory::each(const std::string& network, const std::function<void(Row, KnownDevice&&)>& visit) {
  if (!store_) return;
  const auto read = store_->each(network, [&](Row row, KnownDevice&& known) {
    const auto unwritten = unlisted_.find({known.network, known.address});
    if (unwritten != unlisted_.end()) {
      if (!unwritten->second) return;
      auto stored = std::exchange(known, *unwritten->second);
      known.values = std::move(stored.values);
      known.given_name = std::move(stored.given_name);
      known.area = std::move(stored.area);
    }
    visit(row, std::move(known));
  });
  if (!read) context_.log.error(fmt::format("cannot recall the known devices: {}", read.error().text));
}

void Memory::record_changed(Device& device) {
  device.storage.record_unsaved = true;
  mark(device, kRecordDelay);
}

void Memory::values_changed(DeviceNumber number) {
  if (!writable_) return;
  auto* device = directory_.find(number);
  if (device && !device->storage.values_unsaved) mark(*device, context_.config.save_period);
}

void Memory::property_set(Device& device, Point& point) {
  point.storage.set_by_user = true;
  point.storage.unsaved = true;
  mark(device, kRecordDelay);
  write_soon();
}

void Memory::approved(Device& device) {
  device.storage.decision = Decision::kApproved;
  record_changed(device);
  write_soon();
}

Result<void> Memory::save_names(Device& device) {
  if (!writable_) {
    return fail(ErrorCode::kRefused,
                store_ ? "the state file of this island may only be read: the name would be lost"
                       : "this island has no state file (`state:` in its configuration): the name would be lost");
  }
  const auto now = context_.clock.now().steady;
  if (now - names_since_ >= std::chrono::seconds(1)) {
    names_since_ = now;
    names_ = 0;
  }
  if (++names_ > kMaxNames) return fail(ErrorCode::kBusy, "too many names at once, try again");
  const auto row = device.storage.row;
  if (auto begun = store_->begin(); !begun) return begun;
  auto done = save_name(device);
  if (!done) store_->rollback();
  if (done) done = store_->commit(true);  // undoes by itself what it cannot write
  if (!done) device.storage.row = row;
  return done;
}

Result<void> Memory::save_name(Device& device) {
  auto done = save(device);
  if (done) done = store_->rename(device.storage.row, device.given_name.text(), device.given_area.text());
  if (done || done.error().code != ErrorCode::kNotFound) return done;
  device.storage.row = 0;  // forgotten to make room
  done = save(device);
  return done ? store_->rename(device.storage.row, device.given_name.text(), device.given_area.text()) : done;
}

void Memory::save_unlisted(const std::string& network, const std::string& address, const model::Join& join,
                           Decision decision) {
  if (!writable_) return;
  // Decisions may use twice the room of pending devices.
  const auto limit = context_.config.max_devices * (decision == Decision::kNone ? 1 : 2);
  if (unlisted_.size() >= limit && !unlisted_.contains({network, address})) {
    return context_.warn("state", fmt::format("{} on {} is not remembered: {} others are not written yet", address,
                                              network, unlisted_.size()));
  }
  const auto now = context_.clock.now().wall;
  unlisted_[{network, address}] = KnownDevice{network, address, {}, decision, join, {}, now, now, {}};
  decision == Decision::kNone ? schedule_flush(kRecordDelay) : write_soon();
}

void Memory::forget(const std::string& network, const std::string& address) {
  if (!writable_ || (unlisted_.size() >= context_.config.max_devices && !unlisted_.contains({network, address})))
    return;
  unlisted_[{network, address}] = std::nullopt;
  schedule_flush(Duration(0));
}

void Memory::end_decision(const std::string& network, const std::string& address, const model::Join& join) {
  const auto known = recall(network, address);
  forget(network, address);
  const auto entry = unlisted_.find({network, address});
  if (!known || !is_named(*known) || entry == unlisted_.end()) return;
  const auto now = context_.clock.now().wall;
  entry->second =
      KnownDevice{network, address, {}, Decision::kNone, join, {}, now, now, {}, known->given_name, known->area};
}

void Memory::left(const Device& device) {
  if (device.storage.decision == Decision::kNone) return forget(device.network->id, device.address);
  save_unlisted(device.network->id, device.address, announcement(device), device.storage.decision);
}

void Memory::save_before_removal(std::span<Device* const> devices) {
  std::vector<Device*> unsaved(devices.begin(), devices.end());
  std::erase_if(unsaved, [](const Device* device) { return !device->storage.values_unsaved; });
  if (!writable_ || unsaved.empty()) return;
  if (transaction(durable_, [&] { return write_devices(unsaved); })) return;
  for (const auto* device : unsaved) keep_decision(*device);
}

/// The file cannot be written now and the device is removed: keeps the decision of a user until it can.
void Memory::keep_decision(const Device& device) {
  if (device.storage.decision != Decision::kNone && device.storage.record_unsaved)
    save_unlisted(device.network->id, device.address, announcement(device), device.storage.decision);
}

void Memory::mark(Device& device, Duration within) {
  if (!writable_) return;
  if (!std::exchange(device.storage.values_unsaved, true)) dirty_.push_back(device.number);
  schedule_flush(within);
}

/// Many decisions in a short time share one durable write.
void Memory::write_soon() {
  if (!writable_) return;
  durable_ = true;
  schedule_flush(std::max(Duration(0), Duration(durable_at_ - context_.clock.now().steady)));
}

void Memory::schedule_flush(Duration within) {
  next_flush_.advance_to(context_.clock.now().steady + within);
}

/// Writes one slice in one transaction; what fails is retried after the save period.
void Memory::flush() {
  next_flush_.clear();
  context_.clock.refresh();
  std::vector<Name> unlisted;
  std::vector<Device*> devices;
  const bool saved = transaction(durable_, [&] {
    bool written = true;
    unlisted = write_unlisted(kRowsATurn, written);
    devices = next_devices(kRowsATurn - unlisted.size());
    return written && write_devices(devices);
  });
  if (!saved) {
    for (auto* device : devices) device->storage.row = 0;  // the row may not exist: the transaction failed
    std::erase_if(dirty_, [this](DeviceNumber number) { return !directory_.find(number); });
    return schedule_flush(context_.config.save_period);
  }
  if (durable_) durable_at_ = context_.clock.now().steady + kDurablePause;
  for (const auto& name : unlisted) unlisted_.erase(name);
  for (auto* device : devices) {
    device->storage.record_unsaved = device->storage.values_unsaved = false;
    for (auto& point : device->points) point.storage.unsaved = false;
  }
  std::erase_if(dirty_, [this](DeviceNumber number) {
    const auto* device = directory_.find(number);
    return !device || !device->storage.values_unsaved;
  });
  if (!dirty_.empty() || !unlisted_.empty()) return schedule_flush(Duration(0));
  durable_ = false;
  tidy();
}

void Memory::tidy() {
  const auto now = context_.clock.now().steady;
  if (now < tidy_at_) return;
  tidy_at_ = now + kTidyPause;
  can_continue(store_->tidy());
}

/// False: nothing was written.
bool Memory::transaction(bool durable, const std::function<bool()>& write) {
  auto done = store_->begin();
  const bool written = done && write();
  if (done) done = store_->commit(durable);
  if (!done) context_.warn("state", fmt::format("cannot remember: {}", done.error().text));
  return done && written;
}

/// A device that does not fit is skipped; after any other error the file cannot be written now.
bool Memory::can_continue(const Result<void>& result) {
  if (result) return true;
  context_.warn("state", fmt::format("cannot remember: {}", result.error().text));
  const auto code = result.error().code;
  return code == ErrorCode::kNotFound || code == ErrorCode::kOutOfRange || code == ErrorCode::kBusy;
}

std::vector<Memory::Name> Memory::write_unlisted(std::size_t most, bool& written) {
  std::vector<Name> names;
  for (const auto& [name, known] : unlisted_) {
    if (names.size() >= most || !written) break;
    written = write_one(name, known);
    names.push_back(name);
  }
  return names;
}

bool Memory::write_one(const Name& name, const std::optional<KnownDevice>& known) {
  if (!known) return can_continue(store_->forget(name.first, name.second));
  // An update keeps the decision of a row, so end_decision() removes the row and inserts it again.
  const bool replaces_row = known->decision == Decision::kNone && is_named(*known);
  if (replaces_row && !can_continue(store_->forget(name.first, name.second))) return false;
  const auto row = store_->save(*known);
  return row || can_continue(fail(row.error()));
}

/// The last ones of the list that are still listed.
std::vector<Device*> Memory::next_devices(std::size_t most) {
  std::vector<Device*> devices;
  for (auto at = dirty_.rbegin(); at != dirty_.rend() && devices.size() < most; ++at) {
    if (auto* device = directory_.find(*at)) devices.push_back(device);
  }
  return devices;
}

bool Memory::write_devices(std::span<Device* const> devices) {
  return std::all_of(devices.begin(), devices.end(), [this](Device* device) { return write_one(*device); });
}

bool Memory::write_one(Device& device) {
  auto done = save(device);
  if (done) done = save_values(device);
  if (!done && done.error().code == ErrorCode::kNotFound) {  // forgotten to make room
    device.storage.row = 0;
    done = save(device);
    if (done) done = save_values(device);
  }
  return can_continue(done);
}

Result<void> Memory::save(Device& device) {
  if (!device.storage.record_unsaved && device.storage.row != 0) return {};
  KnownDevice known;
  known.network = device.network->id;
  known.address = device.address;
  known.id = device.id;
  known.decision = device.storage.decision;
  known.given_name = device.given_name.text();
  known.area = device.given_area.text();
  known.join = announcement(device);
  for (const auto& point : device.points) known.point_ids.emplace_back(point.id, point.details->id());
  known.first_seen = context_.clock.now().wall;
  if (device.status == DeviceStatus::kReachable) known.last_heard = known.first_seen;
  auto row = store_->save(known);
  if (!row) return fail(std::move(row.error()));
  device.storage.row = *row;
  return {};
}

Result<void> Memory::save_values(const Device& device) {
  std::vector<StoredValue> values;
  for (const auto& point : device.points) {
    if (!point.storage.unsaved || point.changed == WallTime{} || point.quality == Quality::kStored) continue;
    const auto tuple = context_.space.get(context_.space.self(), point_key(device, point).value());
    if (!tuple) continue;
    // The rate is a value of the proxy: it is no sign that the device was heard.
    const auto heard = is_rate(point) ? WallTime{} : point.heard;
    StoredValue value{point.id,      std::string(tuple->value), heard,
                      point.changed, tuple->user_time,          point.storage.set_by_user};
    if (tuple->media_type == "application/json") value.value = Json{std::string(tuple->value)};
    values.push_back(std::move(value));
  }
  return values.empty() ? Result<void>{} : store_->save_values(device.storage.row, values);
}

}  // namespace rubicon::proxy
