#include "networks/wsn/sink/sink_notifier.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::networks::wsn::sink {

namespace {

constexpr std::uint8_t kSerialAm = 0x00;

}  // namespace

bool SinkNotifier::state(SinkState::Phase phase, std::string reason) {
  if (state_.phase == phase && state_.reason == reason) return true;
  state_ = {phase, std::move(reason)};
  const auto self = lifetime_.watch();
  if (calls_.changed) calls_.changed(state_);
  return !self.ended();
}

bool SinkNotifier::failed(Error why) {
  const auto self = lifetime_.watch();
  if (!state(SinkState::Phase::kOff, why.text)) return false;
  if (calls_.failed) calls_.failed(std::move(why));
  return !self.ended();
}

bool SinkNotifier::received(ByteView packet) {
  const auto self = lifetime_.watch();
  if (packet.empty() || packet.front() != kSerialAm) {
    ++other_dispatch_;
    return note("unknown-dispatches",
                packet.empty() ? std::string("an empty packet from the sink")
                               : fmt::format("a packet with dispatch byte {:02x}, expected 00", packet.front()));
  }
  ++read_;
  if (calls_.received) calls_.received(packet);
  return !self.ended();
}

bool SinkNotifier::left(ByteView packet) {
  const auto self = lifetime_.watch();
  ++written_;
  if (calls_.left) calls_.left(packet);
  return !self.ended();
}

bool SinkNotifier::note(const std::string& subject, std::string_view text) {
  const auto self = lifetime_.watch();
  if (calls_.note) calls_.note(subject, text);
  return !self.ended();
}

void SinkNotifier::room(Lane lane) const {
  if (calls_.room) calls_.room(lane);
}

void SinkNotifier::count(std::map<std::string, std::uint64_t>& into) const {
  into["packets-read"] = read_;
  into["packets-written"] = written_;
  into["unknown-dispatches"] = other_dispatch_;
}

}  // namespace rubicon::networks::wsn::sink
