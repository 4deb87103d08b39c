#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "transport/sockets.h"
#include "transport/transports.h"

namespace rubicon::transport {

/// A user of this host and its groups, each by its number, and by its name if the system has one.
struct UserName {
  std::string user, number;         ///< `ann`, `1000`; twice the number where there is no name
  std::vector<std::string> groups;  ///< `50`, `staff`, ...
  friend bool operator==(const UserName&, const UserName&) = default;
};

/// Asks the system for names, apart from the loop: a directory on another host may take seconds to answer.
class UserNames {
 public:
  /// kIo: the system cannot find out whether there is a name, so the rights of the user are unknown; kBusy: too many
  /// questions wait.
  using Call = std::function<void(const Result<UserName>& name)>;
  /// So long names count.
  static constexpr Duration kKept = std::chrono::minutes(1);
  static constexpr std::size_t kMaxWaiting = 256;

  /// Both outlive it. Transports without threads have numbers only.
  UserNames(Scheduler& scheduler, Transports& transports) : scheduler_(scheduler), transports_(transports) {}

  /// `call` receives the name in a later turn.
  void look_up(const LocalPeer& who, Call call);

 private:
  struct Found {
    std::string name;  ///< empty: the system knows none
    SteadyTime since{};
  };
  /// What is asked for, and answered.
  struct Question {
    std::map<uid_t, Found> users;
    std::map<gid_t, Found> groups;
    bool failed = false;
  };
  Question unknown(const LocalPeer& who) const;
  UserName name_of(const LocalPeer& who) const;
  void keep(const Question& answers);

  Scheduler& scheduler_;
  Transports& transports_;
  std::unique_ptr<Worker> worker_;
  std::size_t waiting_ = 0;
  std::map<uid_t, Found> users_;
  std::map<gid_t, Found> groups_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::transport
