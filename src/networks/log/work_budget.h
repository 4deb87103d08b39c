#pragma once

#include <cstddef>

namespace rubicon::networks::log {

/// Limits the work of one turn of the loop, so that a long recording does not hold up the other networks. Counts in
/// small records, each about 100 ns.
class WorkBudget {
 public:
  void charge(std::size_t records) { used_ += records; }
  void charge_copied(std::size_t bytes) { used_ += bytes / kCopiedPerRecord; }
  void charge_parsed(std::size_t bytes) { used_ += bytes / kParsedPerRecord; }
  /// For work that must be the last of its turn.
  void charge_all() { used_ += kRecords; }

  bool used_up() const { return used_ >= kRecords; }
  /// A new turn.
  void renew() { used_ = 0; }

 private:
  static constexpr std::size_t kRecords = 10'000;
  /// Bytes that take as long as a small record.
  static constexpr std::size_t kCopiedPerRecord = 256, kParsedPerRecord = 16;

  std::size_t used_ = 0;
};

}  // namespace rubicon::networks::log
