#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "network/network.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_point.h"

namespace rubicon::networks::knx {

/// A tuple that the bus can read and is told of.
struct Exposure {
  wire::GroupAddress address{};
  dpt::DptId dpt;
  std::string tuple;                         ///< key of one of this island's, or `ID:key`
  bool on_change = true;                     ///< written when the value changes
  Duration pause = std::chrono::seconds(5);  ///< from one change to the next that is written; the last one always is
  std::optional<Duration> every;             ///< written again after so long

  friend bool operator==(const Exposure&, const Exposure&) = default;
};

/// Keeps the values of exposed tuples and says what has to go out. The host must outlive it.
class Exposures {
 public:
  /// Hands a telegram over for the bus; `done` is told whether the bus has it.
  using Out = std::function<void(wire::Telegram, std::function<void(bool sent)> done)>;
  /// A tuple's value cannot be shown as that type.
  using Unfit = std::function<void(const Exposure&, const Error&)>;

  Exposures(network::NetworkHost& host, const TypeCatalogue& types, Out out, Unfit unfit);

  /// Follows these from now on and no others; what did not change goes on. Tuples that cannot be followed are told.
  void take(std::vector<Exposure> wanted);
  /// The line is up (again): what is known and written is written.
  void line_up();
  void line_down() { up_ = false; }
  /// A GroupRead: answered when the value is known, in the priority of the question. False: not exposed.
  bool asked(const wire::Telegram& question);
  bool shows(wire::GroupAddress address) const;

  std::size_t size() const { return shown_.size(); }

 private:
  struct Shown {
    Exposure what;
    std::string text;    ///< of the tuple; empty = nothing is known
    bool usable = true;  ///< by the status beside it, where there is one
    std::optional<wire::Payload> payload;
    network::TupleWatch value, status;
    Timer again;  ///< cyclic
    Timer pause;  ///< pending: changes wait
    Timer retry;
    bool waits = false;
  };
  void follow(const std::shared_ptr<Shown>& shown, Exposure what);
  void changed(Shown& shown);
  void nothing(Shown& shown);
  void write(Shown& shown);
  void write_change(Shown& shown);
  void rest(Shown& shown);
  void retry(Shown& shown);
  Result<wire::Payload> payload_of(const Exposure& what, std::string_view text) const;

  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  Out out_;
  Unfit unfit_;
  bool up_ = false;
  std::vector<std::shared_ptr<Shown>> shown_;
};

}  // namespace rubicon::networks::knx
