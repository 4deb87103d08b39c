#include "networks/zigbee/bridge/inventory.h"

namespace rubicon::networks::zigbee::bridge {

namespace {

constexpr const char* kGone = "removed from Zigbee2MQTT";
constexpr const char* kLeft = "left the ZigBee network";

}  // namespace

void Presence::listed(std::uint64_t list, std::uint64_t received) {
  listed_in_ = list;
  missing_since_.reset();
  // A list that was published before the device left still has it.
  if (leaving_after_ && received > *leaving_after_) leaving_after_.reset();
}

const char* Presence::lacked(bool live_list, SteadyTime now) {
  if (leaving_after_) return kLeft;
  if (live_list && missing_since_ && missing_live_) return kGone;
  if (!live_list && (heard_ || missing_since_)) return nullptr;
  // A live list restarts the time of a device that so far only a retained copy lacked.
  missing_since_ = now;
  missing_live_ = live_list;
  return nullptr;
}

const char* Presence::overdue(SteadyTime now) const {
  if (!missing_since_) return nullptr;
  if (leaving_after_) return kLeft;
  return *due() <= now ? kGone : nullptr;
}

std::optional<SteadyTime> Presence::due() const {
  if (!missing_since_) return std::nullopt;
  return *missing_since_ + (missing_live_ ? kAbsence : kRetainedAbsence);
}

void Presence::heard() {
  heard_ = true;
  if (!missing_live_) missing_since_.reset();
}

void Presence::line_lost() {
  missing_since_.reset();
  leaving_after_.reset();
  heard_ = false;
}

}  // namespace rubicon::networks::zigbee::bridge
