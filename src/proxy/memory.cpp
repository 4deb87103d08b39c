#include "proxy/memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::proxy {

namespace {

using state::Decision;
using state::KnownDevice;
using state::StoredValue;

constexpr Duration kRecordDelay = std::chrono::seconds(1);
/// Devices written in one turn of the loop.
constexpr std::size_t kSlice = 200;
constexpr Duration kTidyPause = std::chrono::minutes(1);

}  // namespace

model::Join announcement(const Device& device) {
  model::Join join{device.type, device.announced_name, device.model, {}, true, device.wanted_id};
  for (const auto& point : device.points) {
    if (point.details->declared) join.capabilities.push_back(point.details->capability);
  }
  return join;
}

Memory::Memory(Surroundings& around, DeviceDirectory& directory, state::StateStore* store)
    : around_(around), directory_(directory), store_(store), writable_(store && !store->stats().read_only) {}

Memory::~Memory() {
  while (writable_ && (!dirty_.empty() || !absent_.empty())) {
    const auto before = dirty_.size() + absent_.size();
    flush();
    if (dirty_.size() + absent_.size() >= before) return;  // it cannot be written
  }
}

bool Memory::worked(Result<void> result) {
  if (!result) around_.warn("state", fmt::format("cannot remember: {}", result.error().text));
  return result.has_value();
}

std::optional<KnownDevice> Memory::recall(const std::string& network, const std::string& address) {
  if (!store_) return std::nullopt;
  auto found = store_->find(network, address);
  if (found) return std::move(*found);
  around_.warn("state", fmt::format("cannot recall {} on {}: {}", address, network, found.error().text));
  return std::nullopt;
}

void Memory::each(const std::string& network, const std::function<void(KnownDevice&&)>& visit) {
  if (!store_) return;
  const auto read =
      store_->each(network, [&](state::StateStore::Row, KnownDevice&& device) { visit(std::move(device)); });
  if (!read) around_.log.error(fmt::format("cannot recall the known devices: {}", read.error().text));
}

void Memory::record_changed(Device& device) {
  if (!writable_) return;
  device.record_unsaved = true;
  if (!std::exchange(device.values_unsaved, true)) dirty_.push_back(device.number);
  ask(kRecordDelay);
}

void Memory::values_changed(DeviceNumber number) {
  if (!writable_) return;
  auto* device = directory_.find(number);
  if (!device || std::exchange(device->values_unsaved, true)) return;
  dirty_.push_back(number);
  ask(around_.config.save_period);
}

void Memory::ask(Duration within) {
  const auto when = around_.clock.now().steady + within;
  if (when >= flush_at_) return;
  flush_at_ = when;
  timer_ = around_.scheduler.at(when, [this] { flush(); });
}

/// One transaction a slice; what fails is tried again with the next.
void Memory::flush() {
  flush_at_ = SteadyTime::max();
  around_.clock.refresh();
  const auto count = std::min(dirty_.size(), kSlice);
  std::vector<DeviceNumber> slice(dirty_.end() - static_cast<std::ptrdiff_t>(count), dirty_.end());
  const bool saved = transaction(!absent_.empty(), [&] {
    return save_absent() && std::all_of(slice.begin(), slice.end(), [this](DeviceNumber number) {
             auto* device = directory_.find(number);
             return !device || remember(*device);
           });
  });
  if (!saved) {
    std::erase_if(dirty_, [this](DeviceNumber number) { return !directory_.find(number); });
    return ask(around_.config.save_period);
  }
  absent_.clear();
  dirty_.resize(dirty_.size() - count);
  for (const auto number : slice) {
    if (auto* device = directory_.find(number)) written(*device);
  }
  if (!dirty_.empty()) return ask(Duration(0));
  const auto now = around_.clock.now().steady;
  if (now < tidy_at_) return;
  tidy_at_ = now + kTidyPause;
  worked(store_->tidy());
}

/// False: nothing of it is there.
bool Memory::transaction(bool durable, const std::function<bool()>& write) {
  if (!worked(store_->begin())) return false;
  const bool written = write();
  return worked(store_->commit(durable)) && written;
}

void Memory::written(Device& device) {
  device.record_unsaved = device.values_unsaved = false;
  device.saved = around_.clock.now().wall;
}

bool Memory::save_absent() {
  for (const auto& [name, known] : absent_) {
    const auto row = store_->save(known);
    if (!row && !worked(fail(row.error())) && row.error().code != ErrorCode::kOutOfRange) return false;
  }
  return true;
}

bool Memory::remember(Device& device) {
  auto done = save(device);
  if (done) done = save_values(device);
  if (done) return true;
  const auto code = done.error().code;
  // Forgotten to make room: it is written anew the next time.
  if (code == ErrorCode::kNotFound) device.state_row = 0;
  worked(std::move(done));
  return code == ErrorCode::kNotFound || code == ErrorCode::kOutOfRange;
}

Result<void> Memory::save(Device& device) {
  if (!device.record_unsaved && device.state_row != 0) return {};
  KnownDevice known;
  known.network = device.network->id;
  known.address = device.address;
  known.id = device.id;
  known.decision = device.decision;
  known.join = announcement(device);
  for (const auto& point : device.points) known.point_ids.emplace_back(point.id, point.details->id);
  known.first_seen = around_.clock.now().wall;
  auto row = store_->save(known);
  if (!row) return fail(std::move(row.error()));
  device.state_row = *row;
  absent_.erase({known.network, known.address});
  return {};
}

Result<void> Memory::save_values(const Device& device) {
  std::vector<StoredValue> values;
  for (const auto& point : device.points) {
    const bool fresh = std::max(point.heard, point.changed) >= device.saved && point.changed != WallTime{};
    if (!fresh || point.quality == Quality::kStored) continue;
    const auto tuple = around_.space.get(around_.space.self(), point_key(device, point, "value"));
    if (!tuple) continue;
    StoredValue value{point.id,      std::string(tuple->value), point.heard,
                      point.changed, tuple->user_time,          point.details->set_by_user};
    if (tuple->media_type == "application/json") value.value = Json{std::string(tuple->value)};
    values.push_back(std::move(value));
  }
  return values.empty() ? Result<void>{} : store_->save_values(device.state_row, values);
}

void Memory::property_set(Device& device, Point& point) {
  point.details->set_by_user = true;
  device.saved = {};
  save_now(device);
}

void Memory::approved(Device& device) {
  device.decision = Decision::kApproved;
  device.record_unsaved = true;
  save_now(device);
}

/// On the disk when it returns; if that fails, with what else waits.
void Memory::save_now(Device& device) {
  if (!writable_) return;
  if (!transaction(true, [&] { return remember(device); })) values_changed(device.number);
}

void Memory::absent(const std::string& network, const std::string& address, const model::Join& join,
                    Decision decision) {
  if (!writable_) return;
  auto& known = absent_[{network, address}];
  known.network = network;
  known.address = address;
  known.decision = decision;
  known.join = join;
  known.first_seen = around_.clock.now().wall;
  if (decision == Decision::kNone) return ask(kRecordDelay);
  if (transaction(true, [this] { return save_absent(); })) {
    absent_.clear();
  } else {
    ask(around_.config.save_period);
  }
}

void Memory::left(const Device& device) {
  if (!writable_) return;
  if (device.decision != Decision::kNone) {
    absent(device.network->id, device.address, announcement(device), device.decision);
  } else {
    forget(device.network->id, device.address);
  }
}

void Memory::forget(const std::string& network, const std::string& address) {
  if (!writable_) return;
  absent_.erase({network, address});
  auto gone = store_->forget(network, address);
  if (!gone && gone.error().code != ErrorCode::kNotFound) worked(std::move(gone));
}

void Memory::dropped(Device& device) {
  if (!writable_ || !device.values_unsaved) return;
  remember(device);
}

}  // namespace rubicon::proxy
