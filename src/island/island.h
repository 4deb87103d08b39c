#pragma once

#include <functional>
#include <memory>

#include "base/log.h"
#include "base/scheduler.h"
#include "island/island_commands.h"
#include "island/island_config.h"
#include "island/island_tuples.h"
#include "island/recorders.h"
#include "island/reload_plan.h"
#include "rights/rights_judge.h"
#include "rubicon/tuple_space.hpp"
#include "state/state_store.h"
#include "transport/transports.h"
#include "tuples/link.h"

namespace rubicon::island {

/// A whole island: its component of the tuple space, gateway, proxy and networks, wired so that every listener is
/// attached before a line opens. Several may live in one process, on one ecology. Everything taken by reference must
/// outlive it. Without a state file it remembers nothing.
class Island {
 public:
  /// Makes the networks (their own options are checked here, into `errors`) but opens nothing. kDuplicate if the
  /// island's id is present in the ecology, kInvalid if the errors are not empty.
  static Result<std::unique_ptr<Island>> make(island::IslandConfig config, Scheduler& scheduler,
                                              transport::Transports& transports, base::LogSink& log,
                                              tuples::Ecology& ecology, base::ConfigErrors& errors,
                                              std::unique_ptr<state::StateStore> state = nullptr);
  ~Island();

  /// Shows the last lines of this log as a tuple; it must outlive the island.
  void show_log(LogLines& lines);
  /// The judge that the links of the process ask: a reload replaces its rules. Without one a reload that begins or ends
  /// `rights:` is refused. `commands` gets the lines that quote what was set, and must outlive the island: the log that
  /// show_log() shows would give them to those who may not read the actuators.
  void judge_by(std::shared_ptr<rights::RightsJudge> judge, base::LogSink& commands);
  /// Shows what `text` says each time as `<prefix>.property.<name>.value`; empty = nothing. `name`: `[a-z-]+`.
  void show_word(std::string name, std::function<std::string()> text);
  /// Starts the recorders, shows what is remembered, then opens the lines.
  void start();

  /// Lets the networks send their last commands to their devices, at most network::kClosingTime long; then calls
  /// `closed`, once, in a later turn.
  void close(std::function<void()> closed);

  /// What reload() would do with it; its errors.
  Result<island::ReloadPlan> plan(const island::IslandConfig& next, base::ConfigErrors& errors);
  /// Takes another configuration: what did not change is not touched, a network with other options keeps its line if
  /// its type can do that. On an error (kInvalid, or kRefused for what needs a restart) nothing was changed; what is
  /// wrong with the networks' own options stands in `errors`. A network that cannot be made after all is named in the
  /// plan's lines, and made by the next reload.
  Result<island::ReloadPlan> reload(island::IslandConfig next, base::ConfigErrors& errors);

  /// Its tuples of the configuration: who can read the file again says so there, and shows there what came of it.
  SettingsTuples& settings();
  TupleSpace& space();
  gateway::Gateway& gateway();
  network::Supervisor& networks();
  const island::IslandConfig& config() const;

 private:
  struct Impl;
  Island(std::unique_ptr<Impl> impl, Scheduler& scheduler);
  std::unique_ptr<Impl> impl_;
  Scheduler& scheduler_;
};

}  // namespace rubicon::island
