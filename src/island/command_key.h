#pragma once

#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/lifetime.h"
#include "base/scheduler.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "proxy/proxy_config.h"
#include "rubicon/tuple_space.hpp"

namespace rubicon::island {

/// A point of the island itself that takes commands: `<key>.command`, and `<key>.status` with the outcome of the last
/// command as its member `command`, so that commanders follow it like a command to a device
/// (docs/life-of-a-command.md). A command is checked at once and carried out in a later turn, one in each. Destroying
/// it deletes its tuples; commands that wait are dropped.
class CommandKey {
 public:
  /// Commands that may wait; more are refused (busy).
  static constexpr std::size_t kMostWaiting = 16;

  using Ended = std::function<void(const Result<void>& outcome)>;
  struct Calls {
    /// An error refuses the command; it is never carried out.
    std::function<Result<void>(const std::string& text)> check;
    /// An error ends the command: kIo as *failed*, others as *refused*. Must not destroy the CommandKey.
    std::function<Result<void>(const std::string& text)> run;
    /// The other members of the status; may be empty.
    std::function<nlohmann::ordered_json()> status{};
    /// In place of `run`, for commands that take time: without an error the command is *sent* until `ended` is called
    /// (in a later turn), or ends as *timed-out* after `longest`. Until then the reply to further ones is an error
    /// (busy), and the status stays that of the one under way.
    std::function<Result<void>(const std::string& text, Ended ended)> begin{};
    Duration longest{0};
  };
  /// Everything must outlive it.
  struct Place {
    Scheduler& scheduler;
    TupleSpace& space;
    const proxy::ProxyConfig& config;
  };
  CommandKey(Place place, model::PointKey key, Calls calls);
  ~CommandKey();

  const model::PointKey& key() const { return key_; }
  /// Publishes the description.
  void describe(const model::PointDescription& description);
  /// Publishes the status if it changed.
  void show();

 private:
  tuples::SetDecision decide(const tuples::RemoteSet& set);
  void run_next();
  Result<void> begin(const std::string& text);
  void end(const Result<void>& outcome);
  void set_state(std::string_view state, std::string reason, Duration longest = {});

  struct Waiting {
    model::Commander commander;
    std::string text;
  };
  Place place_;
  model::PointKey key_;
  Calls calls_;
  std::deque<Waiting> waiting_;
  std::optional<model::CommandStatus> last_;
  std::uint64_t begun_ = 0;  ///< commands that were carried out or begun: the outcome of an earlier one is dropped
  bool is_under_way_ = false;
  Timer patience_;
  std::string shown_;
  tuples::Handle policy_;
  base::OncePerTurn next_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::island
