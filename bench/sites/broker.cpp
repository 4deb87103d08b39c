#include "sites/broker.h"

#include <sys/resource.h>
#include <unistd.h>

namespace rubicon::bench::sites {

namespace {

constexpr std::uint16_t kPlainPort = 1883, kSecurePort = 8883;

/// Its log goes to a pipe that nobody reads meanwhile.
constexpr const char* kAsInstalled = "set_tcp_nodelay true\nlog_type error\n";
constexpr const char* kRights =
    "pattern read rubicon-space/1/+/p/#\n"
    "pattern write rubicon-space/1/+/p/+/%u/#\n"
    "pattern read rubicon-space/1/+/to/%u/#\n"
    "pattern write rubicon-space/1/+/to/+/+/%u/+\n";

/// A thousand connections need as many descriptors, there and in the processes with many sites.
void allow_descriptors() {
  rlimit limit{};
  ::getrlimit(RLIMIT_NOFILE, &limit);
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

Broker::Broker(const Plan& plan, Report& report, const std::string& what, bool secure) {
  auto reason = support::Mosquitto::missing();
  if (reason.empty() && !plan.is_private) reason = "no private network";
  if (reason.empty() && secure) {
    certificates_ = std::make_unique<support::Certificates>();
    reason = certificates_->reason();
  }
  if (!reason.empty()) {
    report.figure(what + "_skipped", reason);
    return;
  }
  allow_descriptors();
  support::MosquittoOptions options;
  options.port = secure ? kSecurePort : kPlainPort;
  options.more = kAsInstalled;
  if (secure) {
    options.tls = certificates_.get();
    options.asks_for_certificate = true;
    options.acl = kRights;
    options.more += "use_identity_as_username true\n";
  }
  broker_ = std::make_unique<support::Mosquitto>(options);
  await();
}

void Broker::await() const {
  for (int i = 0; i < 2000 && !broker_->ready(); ++i) ::usleep(5'000);
  if (!broker_->ready()) give_up("mosquitto does not come up: " + broker_->errors());
}

Meeting Broker::new_meeting(const Plan& plan) const {
  auto meeting = plan.new_meeting();
  if (certificates_) meeting.trust = certificates_->path("");
  return meeting;
}

double Broker::processor() const {
  return processor_seconds(broker_->process().pid());
}

double Broker::resident_mb() const {
  return rounded(static_cast<double>(broker_->process().resident_kilobytes()) * 1.024 / 1000, 1);
}

void Broker::restart() {
  broker_->kill();
  broker_->start();
  await();
}

std::uint16_t port_of(const Meeting& meeting) {
  return meeting.trust.empty() ? kPlainPort : kSecurePort;
}

}  // namespace rubicon::bench::sites
