#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "base/log.h"
#include "base/scheduler.h"
#include "tuples/judge.h"
#include "tuples/mqtt/topics.h"

namespace rubicon::tuples::mqtt {

/// The realm's document at the broker: one retained message for each user, which all read. A process takes a document
/// that is newer than its own. It publishes its own if no member shows one that is as new. Without I/O.
class Documents {
 public:
  struct Callbacks {
    std::function<void(const std::string& filter)> subscribe;
    std::function<void(std::string topic, std::string payload)> publish;  ///< to be retained without end
  };
  struct Counters {
    std::uint64_t refused = 0;  ///< not signed by the authority, too long, or too many at once
    std::uint64_t old = 0;
  };
  /// The documents of a user are checked at most once in kEach. For all users outside the realm together there are at
  /// most kMaxChecks checks in kWindow.
  static constexpr Duration kEach = std::chrono::seconds(2), kWindow = std::chrono::seconds(1);
  static constexpr unsigned kMaxChecks = 32;
  static constexpr std::size_t kMaxWaiting = std::size_t{4} << 20;  ///< bytes that wait for their check
  static constexpr std::size_t kMaxUsers = 4096;                    ///< users whose documents are checked
  /// If the broker lost a document, each of many members waits a random part of this before it publishes it again.
  static constexpr Duration kSpread = std::chrono::seconds(30);
  static constexpr Duration kShowAgain = std::chrono::minutes(1);  ///< unless the document came back by then

  Documents(const Topics& topics, std::string user, UserRealm& realm, Scheduler& scheduler, base::LimitedLog& log,
            Callbacks calls);

  /// The connection is there: asks for what is shown.
  void connected();
  /// All retained documents were read.
  void read();
  /// The connection is lost.
  void cut();
  /// False: it is not a topic of a document.
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
  Callbacks callbacks_;
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
