#pragma once

#include <map>
#include <string>

#include "tuples/host/connection.h"
#include "tuples/host/folder.h"
#include "tuples/link.h"

namespace rubicon::tuples::host {

/// A process of the folder, this one too: the connection to it, and the components that it showed here.
struct Process {
  struct Component {
    std::uint64_t incarnation = 0;
    std::string host, summary;
    std::map<std::uint32_t, SubscriptionSpec> interests{};  ///< by id
  };
  static constexpr std::size_t kMaxComponents = 1000, kMaxInterests = 10'000;  ///< the latter of one component
  static constexpr std::size_t kMaxBytes = std::size_t{4} << 20;               ///< of all summaries and interests

  explicit Process(Scheduler& scheduler) : connection(scheduler) {}

  Connection connection;
  Door door{};              ///< without a token: not known yet
  bool own = false;         ///< this process
  bool ours = false;        ///< this process connected, not the other
  Member user{};            ///< `user:ann`, with `user:1000` and groups as roles; empty where nobody judges
  bool introduced = false;  ///< it was told what components are here
  bool greeted = false;     ///< its hello came
  bool ready = false;       ///< it told all its components
  bool silent = false;      ///< it answers nothing: its components count as lost
  bool said_goodbye = false;
  bool ended = false;  ///< to be removed in a later turn
  SteadyTime begun{}, heard{};
  SteadyTime asked{};  ///< zero: no question waits for its answer
  std::map<OwnerId, Component> components{};
  std::size_t bytes = 0;  ///< as kMaxBytes counts
};

}  // namespace rubicon::tuples::host
