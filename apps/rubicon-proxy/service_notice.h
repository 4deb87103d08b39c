#pragma once

#include <deque>
#include <string>
#include <string_view>

#include "base/scheduler.h"

namespace rubicon::daemon {

/// What the service manager that started us asked for, in the environment (sd_notify(3), sd_watchdog_enabled(3)).
struct ServiceSettings {
  std::string socket;    ///< NOTIFY_SOCKET: a path, or `@` and an abstract name; empty = wants no notices
  Duration watchdog{0};  ///< WATCHDOG_USEC, when WATCHDOG_PID is not another process; zero = wants no signs of life

  static ServiceSettings from_environment();
};

/// Tells the service manager how we are (sd_notify(3)); does nothing where none asked. Never blocks: what the manager
/// does not take at once waits, bounded. The signs of life come from the loop, so that a loop that is stuck gives none.
class ServiceNotice {
 public:
  ServiceNotice(Scheduler& scheduler, const ServiceSettings& settings);
  ~ServiceNotice();
  ServiceNotice(const ServiceNotice&) = delete;
  ServiceNotice& operator=(const ServiceNotice&) = delete;

  /// Up, or done with a reload. `status` is one line for people; from the first time on signs of life follow.
  void ready(std::string_view status);
  void reloading();
  void stopping(std::string_view status);

  /// Notices that wait at most; older ones are dropped.
  static constexpr std::size_t kMaxQueue = 16;

 private:
  void tell(std::string notice);
  void flush();
  enum class Sent { kYes, kLater, kNever };
  Sent send(std::string_view notice);
  void show_life();

  Scheduler& scheduler_;
  std::string address_;
  Duration watchdog_{0};
  int socket_ = -1;
  std::deque<std::string> waiting_;
  Timer again_, sign_of_life_;
};

}  // namespace rubicon::daemon
