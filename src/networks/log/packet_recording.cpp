#include "networks/log/packet_recording.h"

#include <fmt/format.h>

#include <algorithm>

namespace rubicon::networks::log {

namespace {

/// Keeps a damaged timestamp within the range of microseconds; the replay clock limits it further.
RecordTime time_of(std::chrono::milliseconds written) {
  constexpr std::chrono::milliseconds kFurthest(4'000'000'000'000'000);
  return std::clamp(written, -kFurthest, kFurthest);
}

}  // namespace

PacketRecording::PacketRecording(const TypeCatalogue& types, motes::Calibration calibration, ReplayCounters& counters,
                                 Complaint complain)
    : codec_(types, {calibration}), counters_(counters), complain_(std::move(complain)) {}

void PacketRecording::begin(std::string_view, std::vector<std::string>) {
  reader_ = motes::PacketLogReader();
}

std::optional<Step> PacketRecording::next() {
  while (auto item = reader_.next()) {
    if (const auto* damage = std::get_if<motes::Damage>(&*item)) {
      ++counters_.damaged;
      counters_.skipped_bytes += damage->bytes;
      complain_(damage->offset, fmt::format("{}; {} bytes skipped", damage->why, damage->bytes));
      continue;
    }
    const auto& record = std::get<motes::PacketRecord>(*item);
    if (!record.from_sink) continue;
    if (auto step = step_of(record)) return step;
  }
  return std::nullopt;
}

std::optional<Step> PacketRecording::step_of(const motes::PacketRecord& record) {
  auto events = codec_.decode(record.packet);
  if (!events) {
    ++counters_.damaged;
    complain_(record.offset, events.error().text);
    return std::nullopt;
  }
  ++counters_.records;
  Step step;
  step.time = time_of(record.time);
  step.wall = WallTime(step.time);
  for (model::Message& message : events->messages) {
    if (!message.source.device.empty()) devices_.insert(message.source.device);
    step.messages.emplace_back(std::move(message.source.device), std::move(message.body));
  }
  return step;
}

}  // namespace rubicon::networks::log
