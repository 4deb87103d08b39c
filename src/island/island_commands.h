#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "island/config_desk.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "network/supervisor.h"
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
  static constexpr std::size_t kMaxWaitingCount = 16;

  using Ended = std::function<void(const Result<void>& outcome)>;
  struct Callbacks {
    /// An error refuses the command; it is never carried out.
    std::function<Result<void>(const std::string& text)> check;
    /// An error ends the command: kIo as *failed*, others as *refused*. Must not destroy the CommandKey.
    std::function<Result<void>(const std::string& text)> run;
    /// The other members of the status; may be empty.
    std::function<nlohmann::ordered_json()> status{};
    /// In place of `run`, for commands that take time: without an error the command is *sent* until `ended` is called
    /// (in a later turn), or ends as *timed-out* after `longest`. Until then the reply to further ones is an error
    /// (busy), and the status still shows the running command.
    std::function<Result<void>(const std::string& text, Ended ended)> begin{};
    Duration longest{0};
    /// Who may ask for what; an error refuses the command before `check`.
    std::function<Result<void>(const tuples::RemoteSet& set)> admit{};
  };
  /// Everything must outlive it.
  struct Place {
    Scheduler& scheduler;
    TupleSpace& space;
    const proxy::ProxyConfig& config;
  };
  CommandKey(Place place, model::PointKey key, Callbacks calls);
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
  Callbacks callbacks_;
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

/// The properties of networks themselves that users may set (network::Control), and the command `reopen` of each line:
/// publishes their descriptions, and gives their commands to the networks. Their values come with the state of the
/// network.
class NetworkControls {
 public:
  /// Everything must outlive it.
  NetworkControls(CommandKey::Place place, network::Supervisor& networks) : place_(place), networks_(networks) {}

  /// Networks were added, removed or recreated.
  void refresh();

 private:
  void add_line(const std::string& network);
  void add(const std::string& network, const network::Control& control);
  void add(const model::PointKey& key, const model::PointDescription& description, CommandKey::Callbacks calls);

  CommandKey::Place place_;
  network::Supervisor& networks_;
  std::map<std::string, std::unique_ptr<CommandKey>> all_;  ///< by key
};

/// `<prefix>.settings`: the configuration in force, and the commands `try` and `reload`, which read its file again, and
/// those that change the file (docs/tuple-keys.md). Lives as long as the island, so a reload that recreates networks
/// does not lose its command.
class SettingsTuples {
 public:
  /// Longest text of the configuration in force, in bytes.
  static constexpr std::size_t kMaxTextCount = 512 * 1024;
  /// Changes and errors that one status names; the others are counted.
  static constexpr std::size_t kMaxLineCount = 200;

  /// Reads the configuration again; the lines of what changed (or would change: `try_only`). The text of an error has a
  /// line for each fault, `file:line:column: what` where it has a place.
  using Outcome = Result<std::vector<std::string>>;
  using Reload = std::function<Outcome(bool try_only)>;

  explicit SettingsTuples(CommandKey::Place place);

  /// Without it both commands are refused.
  void on_reload(Reload reload) { reload_ = std::move(reload); }
  /// Who changes the file; must outlive it. Without it such commands are refused.
  void change_by(ConfigDesk& desk) { desk_ = &desk; }
  /// Publishes all tuples.
  void start();
  /// The configuration in force, as YAML without secrets.
  void show_text(const std::string& text);
  /// The outcome of a reload or of an attempt, whatever requested it.
  void show_outcome(bool try_only, const Outcome& outcome);

 private:
  Result<void> admit(const tuples::RemoteSet& set) const;
  Result<void> check(const std::string& text) const;
  Result<void> run(const std::string& text);
  Result<void> end(std::string what, bool tried, const Outcome& outcome);
  void show_networks();
  nlohmann::ordered_json status() const;

  CommandKey::Place place_;
  Reload reload_;
  ConfigDesk* desk_ = nullptr;
  std::string what_;
  bool tried_ = false;  ///< of a change of the file: it was only looked at
  bool refused_ = false;
  WallTime at_{};
  nlohmann::ordered_json changes_ = nlohmann::ordered_json::array();
  nlohmann::ordered_json errors_ = nlohmann::ordered_json::array();
  CommandKey command_;
};

}  // namespace rubicon::island
