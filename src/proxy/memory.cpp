#include "proxy/memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::proxy {

namespace {

using state::Decision;
using state::KnownDevice;
using state::StoredValue;

constexpr Duration kRecordDelay = std::chrono::seconds(1);
/// Between two waits for the disk, however fast users decide.
constexpr Duration kDurablePause = std::chrono::milliseconds(100);
/// Devices written in one turn of the loop.
constexpr std::size_t kRowsATurn = 200;
constexpr Duration kTidyPause = std::chrono::minutes(1);
/// The loop waits for the disk at each: so many names in a second.
constexpr int kMostNames = 20;

}  // namespace

model::Join announcement(const Device& device) {
  model::Join join{device.type, device.announced_name, device.model, {}, true, device.wanted_id.text()};
  for (const auto& point : device.points) {
    if (!point.details->declared) continue;
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
  while (writable_ && (!dirty_.empty() || !absent_.empty())) {
    const auto before = dirty_.size() + absent_.size();
    flush();
    if (dirty_.size() + absent_.size() >= before) return;  // it cannot be written
  }
}

std::optional<KnownDevice> Memory::recall(const std::string& network, const std::string& address) {
  if (!store_) return std::nullopt;
  const auto unwritten = absent_.find({network, address});
  if (unwritten != absent_.end() && !unwritten->second) return std::nullopt;
  auto found = store_->find(network, address);
  if (unwritten != absent_.end()) {
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
    const auto unwritten = absent_.find({known.network, known.address});
    if (unwritten != absent_.end()) {
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
  device.record_unsaved = true;
  mark(device, kRecordDelay);
}

void Memory::values_changed(DeviceNumber number) {
  if (!writable_) return;
  auto* device = directory_.find(number);
  if (device && !device->values_unsaved) mark(*device, context_.config.save_period);
}

void Memory::property_set(Device& device, Point& point) {
  point.details->set_by_user = true;
  point.unsaved = true;
  mark(device, kRecordDelay);
  soon();
}

void Memory::approved(Device& device) {
  device.decision = Decision::kApproved;
  record_changed(device);
  soon();
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
  if (++names_ > kMostNames) return fail(ErrorCode::kBusy, "too many names at once, try again");
  const auto row = device.state_row;
  if (auto begun = store_->begin(); !begun) return begun;
  auto done = save_name(device);
  if (!done) store_->rollback();
  if (done) done = store_->commit(true);  // undoes by itself what it cannot write
  if (!done) device.state_row = row;
  return done;
}

Result<void> Memory::save_name(Device& device) {
  auto done = save(device);
  if (done) done = store_->rename(device.state_row, device.given_name.text(), device.given_area.text());
  if (done || done.error().code != ErrorCode::kNotFound) return done;
  device.state_row = 0;  // forgotten to make room
  done = save(device);
  return done ? store_->rename(device.state_row, device.given_name.text(), device.given_area.text()) : done;
}

void Memory::absent(const std::string& network, const std::string& address, const model::Join& join,
                    Decision decision) {
  if (!writable_) return;
  // A decision goes before what only waits.
  const auto limit = context_.config.max_devices * (decision == Decision::kNone ? 1 : 2);
  if (absent_.size() >= limit && !absent_.contains({network, address})) {
    return context_.warn("state", fmt::format("{} on {} is not remembered: {} others could not be written yet", address,
                                              network, absent_.size()));
  }
  const auto now = context_.clock.now().wall;
  absent_[{network, address}] = KnownDevice{network, address, {}, decision, join, {}, now, now, {}};
  decision == Decision::kNone ? ask(kRecordDelay) : soon();
}

void Memory::forget(const std::string& network, const std::string& address) {
  if (!writable_ || (absent_.size() >= context_.config.max_devices && !absent_.contains({network, address}))) return;
  absent_[{network, address}] = std::nullopt;
  ask(Duration(0));
}

void Memory::left(const Device& device) {
  if (device.decision == Decision::kNone) return forget(device.network->id, device.address);
  absent(device.network->id, device.address, announcement(device), device.decision);
}

void Memory::dropped(std::span<Device* const> devices) {
  std::vector<Device*> unsaved(devices.begin(), devices.end());
  std::erase_if(unsaved, [](const Device* device) { return !device->values_unsaved; });
  if (!writable_ || unsaved.empty()) return;
  if (transaction(durable_, [&] { return write_devices(unsaved); })) return;
  for (const auto* device : unsaved) keep_decision(*device);
}

/// The file cannot be written now, and the device goes: what a user decided waits without it.
void Memory::keep_decision(const Device& device) {
  if (device.decision != Decision::kNone && device.record_unsaved)
    absent(device.network->id, device.address, announcement(device), device.decision);
}

void Memory::mark(Device& device, Duration within) {
  if (!writable_) return;
  if (!std::exchange(device.values_unsaved, true)) dirty_.push_back(device.number);
  ask(within);
}

/// What a user decided is on the disk soon; what a crowd of them decides waits for the disk once.
void Memory::soon() {
  if (!writable_) return;
  durable_ = true;
  ask(std::max(Duration(0), Duration(durable_at_ - context_.clock.now().steady)));
}

void Memory::ask(Duration within) {
  next_flush_.advance_to(context_.clock.now().steady + within);
}

/// One transaction a slice; what fails is tried again after the save period.
void Memory::flush() {
  next_flush_.clear();
  context_.clock.refresh();
  std::vector<Name> absent;
  std::vector<Device*> devices;
  const bool saved = transaction(durable_, [&] {
    bool written = true;
    absent = write_absent(kRowsATurn, written);
    devices = next_devices(kRowsATurn - absent.size());
    return written && write_devices(devices);
  });
  if (!saved) {
    for (auto* device : devices) device->state_row = 0;  // it may never have got that one
    std::erase_if(dirty_, [this](DeviceNumber number) { return !directory_.find(number); });
    return ask(context_.config.save_period);
  }
  if (durable_) durable_at_ = context_.clock.now().steady + kDurablePause;
  for (const auto& name : absent) absent_.erase(name);
  for (auto* device : devices) {
    device->record_unsaved = device->values_unsaved = false;
    for (auto& point : device->points) point.unsaved = false;
  }
  std::erase_if(dirty_, [this](DeviceNumber number) {
    const auto* device = directory_.find(number);
    return !device || !device->values_unsaved;
  });
  if (!dirty_.empty() || !absent_.empty()) return ask(Duration(0));
  durable_ = false;
  tidy();
}

void Memory::tidy() {
  const auto now = context_.clock.now().steady;
  if (now < tidy_at_) return;
  tidy_at_ = now + kTidyPause;
  goes_on(store_->tidy());
}

/// False: nothing of it is there.
bool Memory::transaction(bool durable, const std::function<bool()>& write) {
  auto done = store_->begin();
  const bool written = done && write();
  if (done) done = store_->commit(durable);
  if (!done) context_.warn("state", fmt::format("cannot remember: {}", done.error().text));
  return done && written;
}

/// What does not fit is left out; every other error means that the file cannot be written now.
bool Memory::goes_on(const Result<void>& result) {
  if (result) return true;
  context_.warn("state", fmt::format("cannot remember: {}", result.error().text));
  const auto code = result.error().code;
  return code == ErrorCode::kNotFound || code == ErrorCode::kOutOfRange || code == ErrorCode::kBusy;
}

std::vector<Memory::Name> Memory::write_absent(std::size_t most, bool& written) {
  std::vector<Name> names;
  for (const auto& [name, known] : absent_) {
    if (names.size() >= most || !written) break;
    written = write_one(name, known);
    names.push_back(name);
  }
  return names;
}

bool Memory::write_one(const Name& name, const std::optional<KnownDevice>& known) {
  if (!known) return goes_on(store_->forget(name.first, name.second));
  const auto row = store_->save(*known);
  return row || goes_on(fail(row.error()));
}

/// The last ones of the list that are still there.
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
    device.state_row = 0;
    done = save(device);
    if (done) done = save_values(device);
  }
  return goes_on(done);
}

Result<void> Memory::save(Device& device) {
  if (!device.record_unsaved && device.state_row != 0) return {};
  KnownDevice known;
  known.network = device.network->id;
  known.address = device.address;
  known.id = device.id;
  known.decision = device.decision;
  known.given_name = device.given_name.text();
  known.area = device.given_area.text();
  known.join = announcement(device);
  for (const auto& point : device.points) known.point_ids.emplace_back(point.id, point.details->id);
  known.first_seen = context_.clock.now().wall;
  if (device.status == DeviceStatus::kReachable) known.last_heard = known.first_seen;
  auto row = store_->save(known);
  if (!row) return fail(std::move(row.error()));
  device.state_row = *row;
  return {};
}

Result<void> Memory::save_values(const Device& device) {
  std::vector<StoredValue> values;
  for (const auto& point : device.points) {
    if (!point.unsaved || point.changed == WallTime{} || point.quality == Quality::kStored) continue;
    const auto tuple = context_.space.get(context_.space.self(), point_key(device, point).value());
    if (!tuple) continue;
    // The rate is the proxy's own: it says nothing about when the device was heard.
    const auto heard = is_rate(point) ? WallTime{} : point.heard;
    StoredValue value{point.id,      std::string(tuple->value), heard,
                      point.changed, tuple->user_time,          point.details->set_by_user};
    if (tuple->media_type == "application/json") value.value = Json{std::string(tuple->value)};
    values.push_back(std::move(value));
  }
  return values.empty() ? Result<void>{} : store_->save_values(device.state_row, values);
}

}  // namespace rubicon::proxy
