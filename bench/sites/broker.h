#pragma once

#include <memory>
#include <string>

#include "components/report.h"
#include "support/mosquitto.h"

namespace rubicon::bench::sites {

/// mosquitto as installed, with its queues, but for TCP_NODELAY; in the private network of this process.
class Broker {
 public:
  /// With TLS, certificates of clients and the rights of docs/sites.md if `secure`. If there can be none, the report
  /// says why, and all else must not be called.
  Broker(const Plan& plan, Report& report, const std::string& what, bool secure = false);

  explicit operator bool() const { return broker_ != nullptr; }
  /// A space of its own at this broker.
  Meeting new_meeting(const Plan& plan) const;
  /// Processor time so far, in seconds.
  double processor() const;
  double resident_mb() const;
  /// SIGKILL, and a new one at once.
  void restart();

 private:
  void await() const;

  std::unique_ptr<support::Certificates> certificates_;
  std::unique_ptr<support::Mosquitto> broker_;
};

/// Of the broker of a meeting.
std::uint16_t port_of(const Meeting& meeting);

}  // namespace rubicon::bench::sites
