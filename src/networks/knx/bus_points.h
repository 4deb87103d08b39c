#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/group_reads.h"
#include "networks/knx/point_table.h"

namespace rubicon::networks::knx {

/// The points of the network on the bus: values in, questions and commands out. Knows when each has to be asked
/// (knx.md, section 8). The host must outlive it.
class BusPoints {
 public:
  struct Counters {
    std::uint64_t readings = 0, bad_values = 0, commands = 0, failed_commands = 0;
  };
  using Say = std::function<void(const std::string& subject, std::string_view text)>;

  BusPoints(network::NetworkHost& host, GroupReads::Options reads, Say say);

  /// Other points from now on; those that stay keep what they know. Delivers joins and leaves once begin() was called.
  void take(PointTable table);
  void begin();
  /// Everything marked or wanted is asked again.
  void line_up(line::Line& line);
  void line_down();
  /// A response or write of the bus, or a write of ours that the bus has; false if the address means nothing here.
  bool heard(const wire::Telegram& telegram);
  Result<void> actuate(const std::string& device, const model::Actuate& command);
  Result<void> sample(const std::string& device, const model::Sample& wish);

  const PointTable& table() const { return table_; }
  const Counters& counters() const { return counters_; }
  const GroupReads& reads() const { return reads_; }

 private:
  void join(const std::string& device);
  /// `commanded`: whose command it was; that is no report of its own.
  bool hear(const wire::Telegram& telegram, const BoundPoint* commanded);
  void update(BoundPoint& point, wire::PayloadView payload);
  void ask(const BoundPoint& point, GroupReads::Rank rank) { reads_.ask(point.source(), rank); }
  void ask_marked();
  void plan(std::size_t index);
  void due(std::size_t index);
  void sent(const std::string& device, const model::Actuate& command, line::SendOutcome outcome, std::string_view why);
  void verify(const std::string& device, const model::Actuate& command);
  bool is_fresh(const BoundPoint& point) const;
  void no_answer(wire::GroupAddress address);

  network::NetworkHost& host_;
  Say say_;
  PointTable table_;
  GroupReads reads_;
  line::Line* line_ = nullptr;
  bool begun_ = false;
  Counters counters_;
  std::map<std::size_t, Timer> periodic_;  ///< of points with expire or every
  /// What was commanded last, until something else is reported: a report of the same bytes means that value.
  struct Commanded {
    std::uint64_t request = 0;
    wire::Payload payload;
    Value value;
    Timer verify;  ///< pending: its report is awaited
  };
  std::map<std::pair<std::string, PointId>, Commanded> commanded_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

}  // namespace rubicon::networks::knx
