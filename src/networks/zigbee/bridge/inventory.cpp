#include "networks/zigbee/bridge/inventory.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "base/text.h"
#include "networks/zigbee/bridge/json_tree.h"

namespace rubicon::networks::zigbee::bridge {
namespace {

/// Stands for a text: of a list, or of a record in it.
using TextHash = std::uint64_t;
TextHash hash_of(std::string_view text) {
  return std::hash<std::string_view>{}(text) + text.size();
}

/// A list that waits to be compared.
struct WaitingList {
  std::string text;
  TextHash hash = 0;
  std::uint64_t received = 0;  ///< number
  bool live = false;           ///< not a retained copy, or after a live list
};

/// A usable device that is interviewed again (it was reset, or lost its parent) stays what it was: until the interview
/// ends, its record has less than before.
void keep_what_was_known(DeviceRecord& record, const DeviceRecord& before) {
  if (record.disabled || record.interview == Interview::kSuccessful) return;
  record.interview = Interview::kSuccessful;
  if (record.role == Role::kUnknown) record.role = before.role;
  if (record.power_source.empty()) record.power_source = before.power_source;
  if (record.firmware.empty()) record.firmware = before.firmware;
  if (record.reportings.empty()) record.reportings = before.reportings;
  if (record.supported && !record.leaves.empty()) return;
  record.supported = before.supported;
  record.vendor = before.vendor;
  record.model = before.model;
  record.description = before.description;
  record.leaves = before.leaves;
  record.skipped = before.skipped;
  record.options = before.options;
}

}  // namespace

struct Inventory::Impl {
  struct Known {
    DeviceRecord record;
    std::string why;    ///< it waits; empty = usable
    TextHash text = 0;  ///< what the record was read from
    Presence presence;
  };
  /// Devices that are gone: address, reason.
  using Gone = std::vector<std::pair<std::string, std::string>>;
  /// What a record of the last list is.
  struct Slice {
    enum class Kind : std::uint8_t { kDevice, kCoordinator, kUnreadable, kDuplicate, kTooMany };
    Kind kind = Kind::kDevice;
    std::string address;  ///< empty = not known
  };
  using Slices = std::unordered_map<TextHash, Slice>;
  /// A list that is being compared.
  struct Current {
    explicit Current(WaitingList list)
        : slices(std::move(list.text)), hash(list.hash), received(list.received), live(list.live) {}
    ListSlices slices;
    TextHash hash;
    std::uint64_t received;
    bool live;
    Slices found;
    std::size_t records = 0;
    bool complete = true;  ///< a device that is absent from it is absent from the bridge
    bool too_many = false;
    bool lost = false;  ///< the line was lost since it was received
  };

  Impl(Scheduler& used_scheduler, std::size_t most, Callbacks used_calls)
      : scheduler(used_scheduler),
        most_devices(most),
        calls(std::move(used_calls)),
        next_turn(scheduler, [this] { turn(); }),
        repeated_list(scheduler, [this] { calls.compared(); }),
        absence_check(scheduler, [this] { leave_overdue(); }),
        absence(scheduler, [this] { leave_overdue(); }) {}

  void receive(std::string_view payload, bool retained);
  bool compared_before(TextHash hash, bool live) const { return last == hash && (last_live || !live); }
  void turn();
  bool begin();
  bool continue_list();
  std::size_t take(std::string_view slice);
  bool take_known(TextHash hash);
  bool still_true(const Slice& slice, TextHash hash);
  Slice read(std::string_view slice, TextHash hash);
  Slice apply(DeviceRecord record, TextHash hash);
  void share_definition(DeviceRecord& record);
  void compare(Known& known, DeviceRecord record);
  void listed(const std::string& address);
  void end_list();
  Presence* presence(const std::string& address);
  bool is_listed(const std::string& address) const;
  template <class Call>
  void each_presence(const Call& call);
  Gone note_absences();
  void leave_overdue();
  void leave(const Gone& gone);
  void unreadable(const Error& error);

  Scheduler& scheduler;
  std::size_t most_devices;
  Callbacks calls;
  std::map<std::string, Known> devices;      ///< by address
  std::map<std::string, Presence> expected;  ///< by address; none of the devices
  struct Definition {
    base::SharedList<exposes::Leaf> leaves;
    base::SharedList<std::string> options;
  };
  std::map<std::string, Definition> definitions;  ///< by the model; some device has it
  std::optional<WaitingList> waiting;
  std::unique_ptr<Current> current;
  std::optional<TextHash> last;  ///< the list that was compared last
  bool last_live = false;        ///< it was
  bool last_complete = false;    ///< a device that is absent from it is absent from the bridge
  Slices slices;                 ///< of that list
  bool live_list = false;        ///< one arrived since the line was lost
  std::uint64_t lists_compared = 0;
  bool too_many_reported = false;
  Counters counters;
  base::OncePerTurn next_turn, repeated_list, absence_check;
  base::Deadline absence;
  base::Lifetime lifetime;
};

void Inventory::Impl::receive(std::string_view payload, bool retained) {
  if (base::trimmed(payload).empty()) return;  // the broker forgot the list; the devices are still there
  ++counters.lists;
  live_list = live_list || !retained;
  const auto hash = hash_of(payload);
  if (waiting) {
    waiting->live = live_list;
    if (waiting->hash == hash) return void(++counters.repeated);
    ++counters.replaced;
  } else if (current && !current->lost && current->hash == hash) {
    current->live = live_list;
    return void(++counters.repeated);
  } else if (!current && compared_before(hash, live_list)) {
    ++counters.repeated;
    return repeated_list.request();
  }
  if (!waiting) waiting.emplace();
  waiting->text.clear();
  waiting->text.reserve(payload.size() + ListSlices::kPadding);
  waiting->text = payload;
  waiting->hash = hash;
  waiting->received = counters.lists;
  waiting->live = live_list;
  next_turn.request();
}

void Inventory::Impl::turn() {
  const auto watch = lifetime.watch();
  const bool more = current ? continue_list() : begin();
  if (!watch.ended() && (more || waiting)) next_turn.request();
}

/// True if the list is to be compared.
bool Inventory::Impl::begin() {
  if (!waiting) return false;
  if (compared_before(waiting->hash, waiting->live)) {  // it came twice, and another one in between was replaced
    ++counters.repeated;
    waiting.reset();
    calls.compared();
    return false;
  }
  current = std::make_unique<Current>(std::move(*waiting));
  waiting.reset();
  ++lists_compared;
  const auto opened = current->slices.open();
  if (opened) return true;
  last = current->hash;
  last_live = current->live;
  current.reset();
  unreadable(opened.error());
  return false;
}

/// True if the list is not finished.
bool Inventory::Impl::continue_list() {
  const auto watch = lifetime.watch();
  std::size_t compared = 0, parsed = 0;
  while (compared < kComparedPerTurn && parsed < kParsedPerTurn) {
    const auto slice = current->slices.next();
    if (!slice) {
      current->complete = false;
      unreadable(slice.error());
      if (!watch.ended()) end_list();
      return false;
    }
    if (!*slice) {
      end_list();
      return false;
    }
    parsed += take(**slice);
    if (watch.ended()) return false;
    counters.longest_turn = std::max(counters.longest_turn, parsed);
    compared += (*slice)->size() + 1;
  }
  return true;
}

/// Returns how many bytes were parsed.
std::size_t Inventory::Impl::take(std::string_view slice) {
  const auto watch = lifetime.watch();
  const auto hash = hash_of(slice);
  if (++current->records > 2 * most_devices + 100) {
    current->complete = false;  // also bounds what is remembered of the slices
    return 0;
  }
  if (take_known(hash)) return 0;
  auto read_slice = read(slice, hash);
  if (watch.ended()) return 0;
  if (read_slice.kind == Slice::Kind::kUnreadable && read_slice.address.empty()) current->complete = false;
  current->found.insert_or_assign(hash, std::move(read_slice));
  return slice.size();
}

/// A record that the last list had too needs no parsing.
bool Inventory::Impl::take_known(TextHash hash) {
  const auto found = slices.find(hash);
  if (found == slices.end() || !still_true(found->second, hash)) return false;
  const auto& slice = found->second;
  listed(slice.address);
  if (slice.kind == Slice::Kind::kUnreadable && slice.address.empty()) current->complete = false;
  if (slice.kind == Slice::Kind::kTooMany) current->too_many = true;
  current->found.emplace(hash, slice);
  return true;
}

/// Whether a record with this text means what it meant in the last list.
bool Inventory::Impl::still_true(const Slice& slice, TextHash hash) {
  const auto known = devices.find(slice.address);
  switch (slice.kind) {
    case Slice::Kind::kDevice: return known != devices.end() && known->second.text == hash;
    case Slice::Kind::kDuplicate: return known != devices.end() && known->second.presence.in_list(lists_compared);
    case Slice::Kind::kTooMany: return known == devices.end() && devices.size() >= most_devices;
    case Slice::Kind::kCoordinator:
    case Slice::Kind::kUnreadable: break;
  }
  return true;
}

Inventory::Impl::Slice Inventory::Impl::read(std::string_view slice, TextHash hash) {
  ++counters.parsed;
  auto record = slice.empty()
                    ? Result<DeviceRecord>(fail(ErrorCode::kInvalid, "bridge/devices: a record is not an object"))
                    : read_device_record(slice);
  if (record) return apply(std::move(*record), hash);
  Slice unread{Slice::Kind::kUnreadable, slice.size() <= 4 * kMaxRecordBytes ? address_in(slice) : std::string()};
  listed(unread.address);
  unreadable(record.error());
  return unread;
}

Inventory::Impl::Slice Inventory::Impl::apply(DeviceRecord record, TextHash hash) {
  const auto address = record.address;
  if (record.role == Role::kCoordinator) return {Slice::Kind::kCoordinator, {}};
  auto known = devices.find(address);
  if (known != devices.end() && known->second.presence.in_list(lists_compared)) {
    unreadable({ErrorCode::kDuplicate, fmt::format("bridge/devices: 0x{} is there twice", address)});
    return {Slice::Kind::kDuplicate, address};
  }
  if (known == devices.end()) {
    if (devices.size() >= most_devices) {
      current->too_many = true;
      listed(address);
      return {Slice::Kind::kTooMany, address};
    }
    known = devices.try_emplace(address).first;
    expected.erase(address);
  }
  listed(address);
  known->second.text = hash;
  share_definition(record);
  compare(known->second, std::move(record));
  return {Slice::Kind::kDevice, address};
}

/// Devices of one model have the same definition, and keep it once.
void Inventory::Impl::share_definition(DeviceRecord& record) {
  auto& known = definitions[record.vendor + '\n' + record.model];
  if (known.leaves == record.leaves && known.options == record.options) {
    record.leaves = known.leaves;
    record.options = known.options;
  } else {
    known = {record.leaves, record.options};
  }
}

void Inventory::Impl::compare(Known& known, DeviceRecord record) {
  const bool is_new = known.record.address.empty();
  if (!is_new && known.why.empty()) keep_what_was_known(record, known.record);
  auto why = why_waiting(record);
  if (!is_new && record == known.record && why == known.why) return;
  known.record = std::move(record);
  known.why = std::move(why);
  if (known.why.empty()) {
    calls.changed(known.record);
  } else {
    calls.waiting(known.record, known.why);
  }
}

void Inventory::Impl::listed(const std::string& address) {
  if (auto* of_device = presence(address)) of_device->listed(lists_compared, current->received);
}

Presence* Inventory::Impl::presence(const std::string& address) {
  if (const auto known = devices.find(address); known != devices.end()) return &known->second.presence;
  const auto found = expected.find(address);
  return found == expected.end() ? nullptr : &found->second;
}

/// Also a device whose record cannot be used.
bool Inventory::Impl::is_listed(const std::string& address) const {
  return std::ranges::any_of(slices, [&](const auto& one) { return one.second.address == address; });
}

template <class Call>
void Inventory::Impl::each_presence(const Call& call) {
  for (auto& [address, known] : devices) call(address, known.presence);
  for (auto& [address, of_device] : expected) call(address, of_device);
}

void Inventory::Impl::end_list() {
  const auto watch = lifetime.watch();
  last_complete = current->complete && !current->lost;
  const auto gone = last_complete ? note_absences() : Gone();
  last = current->lost ? std::nullopt : std::optional(current->hash);
  last_live = current->live;
  slices = std::move(current->found);
  std::erase_if(definitions,
                [](const auto& one) { return one.second.leaves.uses() <= 1 && one.second.options.uses() <= 1; });
  const bool too_many = std::exchange(too_many_reported, current->too_many) < current->too_many;
  current.reset();
  ++counters.compared;
  leave(gone);
  if (watch.ended()) return;
  if (too_many) {
    unreadable({ErrorCode::kBusy,
                fmt::format("bridge/devices: more than {} devices (limits.devices); some are left out", most_devices)});
    if (watch.ended()) return;
  }
  calls.compared();
  if (!watch.ended()) absence_check.request();
}

Inventory::Impl::Gone Inventory::Impl::note_absences() {
  Gone gone;
  each_presence([&](const std::string& address, Presence& of_device) {
    if (of_device.in_list(lists_compared)) return;
    if (const auto* why = of_device.lacked(current->live, scheduler.now()))
      gone.emplace_back(address, why);
    else if (const auto due = of_device.due())
      absence.advance_to(*due);
  });
  return gone;
}

/// While a list is compared, its devices are not known yet. The end of the list checks again.
void Inventory::Impl::leave_overdue() {
  if (current || waiting) return;
  Gone gone;
  absence.clear();
  each_presence([&](const std::string& address, const Presence& of_device) {
    if (const auto* why = of_device.overdue(scheduler.now()))
      gone.emplace_back(address, why);
    else if (const auto due = of_device.due())
      absence.advance_to(*due);
  });
  leave(gone);
}

void Inventory::Impl::leave(const Gone& gone) {
  const auto watch = lifetime.watch();
  for (const auto& [address, reason] : gone) {
    if (devices.erase(address) + expected.erase(address) > 0) calls.left(address, reason);
    if (watch.ended()) return;
  }
}

void Inventory::Impl::unreadable(const Error& error) {
  ++counters.unreadable;
  calls.unreadable(error);
}

Inventory::Inventory(Scheduler& scheduler, std::size_t most_devices, Callbacks calls)
    : impl_(std::make_unique<Impl>(scheduler, most_devices, std::move(calls))) {}
Inventory::~Inventory() = default;

void Inventory::list(std::string_view payload, bool retained) {
  impl_->receive(payload, retained);
}

void Inventory::expect(const std::string& address) {
  auto& impl = *impl_;
  if (impl.devices.contains(address) || impl.expected.size() >= impl.most_devices) return;
  const auto [entry, fresh] = impl.expected.try_emplace(address);
  if (!fresh || !impl.last || !impl.last_complete || impl.is_listed(address)) return;
  std::ignore = entry->second.lacked(impl.last_live, impl.scheduler.now());
  impl.absence.advance_to(*entry->second.due());
}

void Inventory::heard(const std::string& address) {
  if (auto* presence = impl_->presence(address)) presence->heard();
}

void Inventory::leaving(std::string_view address) {
  auto* presence = impl_->presence(std::string(address));
  if (!presence) return;
  presence->leaving(impl_->counters.lists);
  if (presence->due()) impl_->absence_check.request();
}

void Inventory::line_lost() {
  impl_->each_presence([](const std::string&, Presence& presence) { presence.line_lost(); });
  impl_->live_list = false;
  impl_->absence.clear();
  impl_->waiting.reset();
  impl_->last.reset();  // so that the same list is compared again
  if (impl_->current) impl_->current->lost = true;
}

const DeviceRecord* Inventory::find(const std::string& address) const {
  const auto known = impl_->devices.find(address);
  return known == impl_->devices.end() ? nullptr : &known->second.record;
}

const DeviceRecord* Inventory::find_named(std::string_view name) const {
  const auto found =
      std::ranges::find_if(impl_->devices, [&](const auto& device) { return device.second.record.name == name; });
  return found == impl_->devices.end() ? nullptr : &found->second.record;
}

void Inventory::each(const std::function<void(const DeviceRecord& record, const std::string& why)>& call) const {
  for (const auto& [address, known] : impl_->devices) call(known.record, known.why);
}

std::size_t Inventory::size() const {
  return impl_->devices.size();
}

const Inventory::Counters& Inventory::counters() const {
  return impl_->counters;
}

}  // namespace rubicon::networks::zigbee::bridge
