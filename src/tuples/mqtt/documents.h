#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "base/deadline.h"
#include "base/limited_log.h"
#include "tuples/mqtt/topics.h"
#include "tuples/user_realm.h"

namespace rubicon::tuples::mqtt {

/// The realm's document at the broker: one retained message for each user, which all read. A process takes what is
/// newer than its own, and shows its own where nobody shows one that is as new. Without I/O.
class Documents {
 public:
  struct Calls {
    std::function<void(const std::string& filter)> subscribe;
    std::function<void(std::string topic, std::string payload)> publish;  ///< to be retained without end
  };
  struct Counters {
    std::uint64_t refused = 0;  ///< not signed by the authority, too long, or too many at once
    std::uint64_t old = 0;
  };
  /// What a user shows is checked at most so often; that of users whom the realm does not have, besides, at most
  /// kMaxChecks times in a window.
  static constexpr Duration kEach = std::chrono::seconds(2), kWindow = std::chrono::seconds(1);
  static constexpr unsigned kMaxChecks = 32;
  static constexpr std::size_t kMaxWaiting = std::size_t{4} << 20;  ///< bytes that wait for their check
  static constexpr std::size_t kMaxUsers = 4096;                    ///< whose documents are looked at
  /// Until one of many shows again what the broker lost.
  static constexpr Duration kSpread = std::chrono::seconds(30);
  static constexpr Duration kShowAgain = std::chrono::minutes(1);  ///< unless it came back by then

  Documents(const Topics& topics, std::string user, UserRealm& realm, Scheduler& scheduler, base::LimitedLog& log,
            Calls calls);

  /// The connection is there: asks for what is shown.
  void connected();
  /// All that is retained was read.
  void read();
  /// The connection is lost.
  void cut();
  /// False: it is no topic of a document.
  bool received(std::string_view topic, std::string_view payload);
  const Counters& counters() const { return counters_; }

 private:
  struct Shown {
    bool newest = false, old = false;  ///< neither: none, or one that was not checked, or is wrong
    std::string waiting;               ///< not checked yet
    SteadyTime next{};                 ///< check, at the earliest
  };
  void look_at(const std::string& user, Shown& shown, std::string_view document);
  bool may_check(const std::string& user);
  void wait(const std::string& user, Shown& shown, std::string_view document);
  void check(const std::string& user, Shown& shown, std::string_view document);
  void check_waiting();
  void refuse(const std::string& user, std::string_view why);
  void changed();
  const std::string* first_who_shows() const;
  void review();
  void show();

  const Topics& topics_;
  std::string user_;
  UserRealm& realm_;
  Scheduler& scheduler_;
  base::LimitedLog& log_;
  Calls calls_;
  std::map<std::string, Shown, std::less<>> users_;
  std::size_t waiting_ = 0;  ///< bytes
  SteadyTime window_{};
  unsigned checks_ = 0;  ///< in the window
  Duration spread_{};
  bool read_ = false;    ///< what is retained, on this connection
  bool taking_ = false;  ///< one that another user showed
  Counters counters_;
  base::Deadline show_, next_;
  Handle changes_;
};

}  // namespace rubicon::tuples::mqtt
