#pragma once

#include <fmt/format.h>

#include <set>
#include <string>

#include "networks/log/recording.h"
#include "recording/recording_reader.h"

namespace rubicon::networks::log {

/// Counts and reports what cannot be played of a recording. The counters and the reader must outlive it.
class RecordingFaults {
 public:
  RecordingFaults(ReplayCounters& counters, Complaint complain, const recording::RecordingReader& reader)
      : counters_(counters), complain_(std::move(complain)), reader_(reader) {}

  void skipped(const recording::Damage& damage) {
    ++counters_.damaged;
    counters_.skipped_bytes += damage.bytes;
    complain_(damage.offset, fmt::format("{}; {} bytes skipped", damage.why, damage.bytes));
  }
  /// A record that cannot be played.
  void invalid(const std::string& text) {
    ++counters_.damaged;
    complain_(reader_.block_offset(), text);
  }
  /// More of something than is played; reported once for each `what`.
  void limit_exceeded(std::string_view what, std::size_t limit) {
    if (!exceeded_.emplace(what).second) return;
    invalid(fmt::format("more {} than are played, expected at most {}; the others are ignored", what, limit));
  }
  /// A file of another island.
  void foreign_file(const std::string& text) { complain_(0, text); }

 private:
  ReplayCounters& counters_;
  Complaint complain_;
  const recording::RecordingReader& reader_;
  std::set<std::string, std::less<>> exceeded_;
};

}  // namespace rubicon::networks::log
