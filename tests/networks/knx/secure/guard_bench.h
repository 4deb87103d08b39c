#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/virtual_scheduler.h"
#include "networks/knx/secure/group_guard.h"
#include "networks/knx/secure/vectors.h"

namespace rubicon::networks::knx::secure {

constexpr wire::GroupAddress kSecuredGroup{0x0a07};              // 1/2/7
constexpr wire::IndividualAddress kOwn{0x110a}, kOther{0x110b};  // 1.1.10, 1.1.11

/// Values that survive the guard, as a state file.
struct Disk {
  GroupStorage storage() {
    return {[this](std::string_view name, ByteView value) -> Result<void> {
              ++writes;
              if (!failure.empty()) return fail(ErrorCode::kIo, failure);
              values[std::string(name)] = Bytes(value.begin(), value.end());
              return {};
            },
            [this](std::string_view name) -> Result<std::optional<Bytes>> {
              const auto found = values.find(std::string(name));
              return found == values.end() ? std::optional<Bytes>() : std::optional(found->second);
            },
            [this](std::string_view name, ByteView value) -> Result<void> {
              ++soon_writes;
              if (!failure.empty()) return fail(ErrorCode::kIo, failure);
              values[std::string(name)] = Bytes(value.begin(), value.end());
              return {};
            }};
  }
  void store_own(std::uint64_t last) {
    base::ByteWriter value;
    values["secure.sequence"] = value.u64_be(last).take();
  }

  std::map<std::string, Bytes> values;
  std::string failure;
  int writes = 0, soon_writes = 0;  ///< that wait for the disk; that do not
};

/// The group 1/2/7 with the key 30..3f; 1.1.10, 1.1.11, 1.1.12 and 1.1.30 are its senders.
inline GroupKeys one_group(const Key& key = Key(counting(0x30, 16).view())) {
  GroupKeys keys;
  keys.groups[kSecuredGroup] = {key, {kOwn, kOther, wire::IndividualAddress(0x110c), wire::IndividualAddress(0x111e)}};
  return keys;
}

inline wire::Telegram value_for(wire::GroupAddress group, Bytes bytes = {0x0c, 0x33}, bool small = false) {
  wire::Telegram telegram;
  telegram.destination = group;
  telegram.payload = {std::move(bytes), small};
  return telegram;
}

/// A guard in virtual time, with what it noted.
struct GuardBench {
  GroupGuard& start(GroupKeys keys = one_group(), wire::IndividualAddress own = kOwn) {
    return start(std::move(keys), disk.storage(), own);
  }
  GroupGuard& start(GroupKeys keys, GroupStorage storage, wire::IndividualAddress own = kOwn) {
    guard.reset();  // the old one writes before the new one reads
    guard = std::make_unique<GroupGuard>(time, std::move(keys), std::move(storage), own,
                                         [this](std::string_view, std::string_view text) { notes.emplace_back(text); });
    return *guard;
  }
  std::uint64_t count(const std::string& name) const { return guard->counters().at(name); }

  VirtualScheduler time;
  Disk disk;
  std::vector<std::string> notes;
  std::unique_ptr<GroupGuard> guard;
};

/// An L_Data.ind that a device sends.
inline Bytes indication(wire::IndividualAddress source, std::uint64_t sequence, wire::Telegram telegram,
                        const Key& key = Key(counting(0x30, 16).view()), std::uint8_t scf = control::kEncrypted) {
  telegram.source = source;
  const auto plain = wire::write_telegram(wire::CemiCode::kDataIndication, telegram).value();
  auto frame = wire::read_data_frame(plain).value();
  Ccm ccm;
  const auto tpdu = seal(ccm, key, frame, scf, sequence).value();
  frame.tpdu = tpdu;
  if (tpdu.size() > 16) frame.control1 &= 0x7f;
  return wire::write(frame);
}

inline GroupGuard::Opened opened(GroupGuard& guard, const Bytes& cemi, wire::IndividualAddress own = {}) {
  return guard.open(wire::read_data_frame(cemi).value(), own);
}

}  // namespace rubicon::networks::knx::secure
