#include "networks/wsn/sink/sink_notifier.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::wsn::sink {

namespace {

constexpr std::uint8_t kSerialAm = 0x00;

}  // namespace

bool SinkNotifier::set_state(SinkState::Phase phase, std::string reason) {
  if (state_.phase == phase && state_.reason == reason) return true;
  state_ = {phase, std::move(reason)};
  const auto self = lifetime_.watch();
  if (callbacks_.changed) callbacks_.changed(state_);
  return !self.ended();
}

bool SinkNotifier::failed(Error why) {
  const auto self = lifetime_.watch();
  if (!set_state(SinkState::Phase::kOff, why.text)) return false;
  if (callbacks_.failed) callbacks_.failed(std::move(why));
  return !self.ended();
}

bool SinkNotifier::received(ByteView packet) {
  const auto self = lifetime_.watch();
  if (packet.empty() || packet.front() != kSerialAm) {
    ++unknown_dispatches_;
    return note("unknown-dispatches",
                packet.empty() ? std::string("an empty packet from the sink")
                               : fmt::format("a packet with dispatch byte {:02x}, expected 00", packet.front()));
  }
  ++read_;
  if (callbacks_.received) callbacks_.received(packet);
  return !self.ended();
}

bool SinkNotifier::sent(ByteView packet) {
  const auto self = lifetime_.watch();
  ++written_;
  if (callbacks_.sent) callbacks_.sent(packet);
  return !self.ended();
}

bool SinkNotifier::note(const std::string& subject, std::string_view text) {
  const auto self = lifetime_.watch();
  if (callbacks_.note) callbacks_.note(subject, text);
  return !self.ended();
}

void SinkNotifier::room(Lane lane) const {
  if (callbacks_.room) callbacks_.room(lane);
}

void SinkNotifier::count(std::map<std::string, std::uint64_t>& into) const {
  into["packets-read"] = read_;
  into["packets-written"] = written_;
  into["unknown-dispatches"] = unknown_dispatches_;
}

}  // namespace rubicon::networks::wsn::sink
