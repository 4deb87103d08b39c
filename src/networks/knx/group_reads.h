#pragma once

#include <array>
#include <deque>
#include <functional>
#include <map>
#include <string_view>

#include "base/scheduler.h"
#include "networks/knx/line/line.h"

namespace rubicon::networks::knx {

/// Reads group addresses, a few at a time (knx.md, section 8). Any response or write to the address counts as the
/// answer. After 2 s without an answer a read is repeated once; then `no_answer` is called. A read that the line
/// refuses is not repeated.
class GroupReads {
 public:
  /// Why a value is read. Each rank has its own bound of open reads, so that unanswered reads of one do not delay
  /// another.
  enum class Rank : std::uint8_t { kVerify, kSubscribed, kReconnected, kConfigured };
  static constexpr std::size_t kRanks = 4;

  struct Options {
    std::array<std::size_t, kRanks> open{2, 4, 2, 2};  ///< open reads, by rank
    Duration answer_time = std::chrono::seconds(2);
  };
  /// `why`: the line refused the read; empty: no device answered.
  using NoAnswer = std::function<void(wire::GroupAddress, std::string_view why)>;

  GroupReads(Scheduler& scheduler, Options options, NoAnswer no_answer);

  /// Sends reads over this line; nullptr: they wait.
  void use(line::Line* line);
  /// Several requests for an address before its answer become one read, in the best rank requested.
  void add(wire::GroupAddress address, Rank rank);
  /// A response or write was received.
  void received(wire::GroupAddress address);
  /// Drops the reads of all other addresses.
  void keep(const std::function<bool(wire::GroupAddress)>& wanted);

  std::size_t waiting() const { return ranks_.size() + open_.size(); }
  std::uint64_t sent_count() const { return sent_; }
  std::uint64_t unanswered() const { return unanswered_; }

 private:
  struct OpenRead {
    Rank rank = Rank::kConfigured;
    unsigned attempts = 0;
    bool queued = false;  ///< the line has not sent it yet
    Timer timeout;
  };
  void fill();
  void put(wire::GroupAddress address);
  void sent(wire::GroupAddress address);
  void timed_out(wire::GroupAddress address);
  void give_up(wire::GroupAddress address, std::string_view why);

  Scheduler& scheduler_;
  Options options_;
  NoAnswer no_answer_;
  line::Line* line_ = nullptr;
  std::array<std::deque<wire::GroupAddress>, kRanks>
      queues_;                                ///< entries that are not in ranks_ with this rank are ignored
  std::map<wire::GroupAddress, Rank> ranks_;  ///< of those that wait
  std::map<wire::GroupAddress, OpenRead> open_;
  std::array<std::size_t, kRanks> open_count_{};
  std::uint64_t sent_ = 0, unanswered_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx
