#include "apps/rubicon-proxy/service_notice.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#include "base/text.h"

namespace rubicon::daemon {

namespace {

constexpr Duration kRetry = std::chrono::milliseconds(50);

std::string_view environment(const char* name) {
  const char* text = std::getenv(name);
  return text ? std::string_view(text) : std::string_view();
}

std::uint64_t whole_number(std::string_view text) {
  return base::parse_number<std::uint64_t>(text).value_or(0);
}

/// A notice is a list of lines: the status of one must not begin another.
std::string status_line(std::string_view status) {
  return base::one_line(status.substr(0, 500));
}

}  // namespace

ServiceSettings ServiceSettings::from_environment() {
  ServiceSettings settings{std::string(environment("NOTIFY_SOCKET"))};
  const auto process = environment("WATCHDOG_PID");
  if (!process.empty() && whole_number(process) != static_cast<std::uint64_t>(::getpid())) return settings;
  constexpr std::uint64_t kMaxTime = 86'400'000'000;  // a day
  settings.watchdog = std::chrono::microseconds(std::min(whole_number(environment("WATCHDOG_USEC")), kMaxTime));
  return settings;
}

ServiceNotice::ServiceNotice(Scheduler& scheduler, const ServiceSettings& settings)
    : scheduler_(scheduler), address_(settings.socket), watchdog_(settings.watchdog) {
  const bool usable = address_.size() > 1 && (address_[0] == '/' || address_[0] == '@') &&
                      address_.size() < sizeof(sockaddr_un::sun_path);
  if (usable) socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}

ServiceNotice::~ServiceNotice() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceNotice::ready(std::string_view status) {
  tell(fmt::format("READY=1\nSTATUS={}", status_line(status)));
  if (watchdog_ > Duration::zero() && !sign_of_life_.pending()) show_life();
}

void ServiceNotice::reloading() {
  const auto now = std::chrono::floor<std::chrono::microseconds>(scheduler_.now().time_since_epoch());
  tell(fmt::format("RELOADING=1\nMONOTONIC_USEC={}", now.count()));
}

void ServiceNotice::stopping(std::string_view status) {
  tell(fmt::format("STOPPING=1\nSTATUS={}", status_line(status)));
}

void ServiceNotice::show_life() {
  // A notice that the manager cannot take now is not repeated: it would only say that we were alive.
  if (waiting_.empty() && socket_ >= 0) send("WATCHDOG=1");
  sign_of_life_ = scheduler_.after(watchdog_ / 2, [this] { show_life(); });
}

void ServiceNotice::tell(std::string notice) {
  if (socket_ < 0) return;
  waiting_.push_back(std::move(notice));
  if (waiting_.size() > kMaxQueue) waiting_.pop_front();
  flush();
}

void ServiceNotice::flush() {
  while (!waiting_.empty()) {
    if (send(waiting_.front()) == Sent::kLater) {
      again_ = scheduler_.after(kRetry, [this] { flush(); });
      return;
    }
    waiting_.pop_front();
  }
}

ServiceNotice::Sent ServiceNotice::send(std::string_view notice) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), to.sun_path);
  if (to.sun_path[0] == '@') to.sun_path[0] = '\0';  // the spelling of abstract names
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  const auto* address = reinterpret_cast<const sockaddr*>(&to);
  if (::sendto(socket_, notice.data(), notice.size(), MSG_NOSIGNAL, address, length) >= 0) return Sent::kYes;
  const bool full = errno == EAGAIN || errno == EWOULDBLOCK || errno == ENOBUFS || errno == EINTR;
  return full ? Sent::kLater : Sent::kNever;
}

}  // namespace rubicon::daemon
