#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "network/network.h"
#include "networks/knx/group_reads.h"
#include "networks/knx/point_table.h"
#include "networks/knx/problems.h"

namespace rubicon::networks::knx {

/// The points of the network: turns telegrams into readings and commands into telegrams, and decides when to read each
/// point from the bus (knx.md, section 8). The host must outlive it.
class BusPoints {
 public:
  struct Counters {
    std::uint64_t readings = 0, bad_values = 0, commands = 0, failed_commands = 0;
  };
  using Report = std::function<void(const Problem&)>;

  BusPoints(network::NetworkHost& host, GroupReads::Options reads, Report report);

  /// Replaces the points; those that stay keep their state. After begin() it delivers joins and leaves.
  void set_table(PointTable table);
  void begin();
  /// Reads all points again that are subscribed to or configured to be read.
  void line_up(line::Line& line);
  void line_down();
  /// Handles a response or write from the bus, or a sent write that the bus confirmed. False if no point has the
  /// address.
  bool receive(const wire::Telegram& telegram) { return receive(telegram, nullptr); }
  Result<void> actuate(const std::string& device, const model::Actuate& command);
  Result<void> sample(const std::string& device, const model::Sample& request);

  const PointTable& table() const { return table_; }
  const Counters& counters() const { return counters_; }
  const GroupReads& reads() const { return reads_; }

 private:
  void join(const std::string& device);
  /// A sent telegram also updates other points of its address, but not the point that it commands (`except`).
  bool receive(const wire::Telegram& telegram, const BoundPoint* except);
  void update(BoundPoint& point, wire::PayloadView payload);
  void read(const BoundPoint& point, GroupReads::Rank rank) { reads_.add(point.source(), rank); }
  void read_all();
  void start_period(std::size_t index);
  void period_ended(std::size_t index);
  void sent(const std::string& device, const model::Actuate& command, line::SendOutcome outcome, std::string_view why);
  void verify(const std::string& device, const model::Actuate& command);
  bool is_fresh(const BoundPoint& point) const;
  void no_answer(wire::GroupAddress address, std::string_view why);

  network::NetworkHost& host_;
  Report report_;
  PointTable table_;
  GroupReads reads_;
  line::Line* line_ = nullptr;
  bool begun_ = false;
  Counters counters_;
  std::map<std::size_t, Timer> periodic_;  ///< of points with `read: expire` or `read: every`
  /// The last command, until another value is reported. A report with the same bytes means the commanded value, which
  /// may have lost digits on the bus.
  struct Commanded {
    std::uint64_t request = 0;
    wire::Payload payload;
    Value value;
    Timer verify;  ///< pending: the report is due
  };
  std::map<std::pair<std::string, PointId>, Commanded> commanded_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::knx
