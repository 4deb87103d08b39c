#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <thread>
#include <utility>
#include <vector>

#include "ecology/measurements.h"
#include "transport/descriptor_watch.h"

// What it takes the system to connect each of many processes with each other one by a Unix stream, and to pass one
// message each way: the floor of a crowd on engine host.

namespace rubicon::bench {

namespace {

constexpr std::size_t kHelloBytes = 200;
constexpr auto kTryAgain = std::chrono::milliseconds(1);

using BareSocket = transport::OwnDescriptor;

/// In the abstract namespace, so that nothing is left.
std::pair<sockaddr_un, socklen_t> bare_place_of(const Meeting& meeting, int number) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto name = fmt::format("{}-{}", meeting.tag, number);
  name.copy(static_cast<char*>(address.sun_path) + 1, sizeof address.sun_path - 1);
  return {address, static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())};
}

class BareMember {
 public:
  BareMember(const Meeting& meeting, int number, int count) : meeting_(meeting), number_(number), count_(count) {
    const auto [address, size] = bare_place_of(meeting, number);
    if (::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0 ||
        ::listen(listener_.get(), count) != 0)
      give_up("no bare socket");
    watch(listener_.get());
  }

  /// Connects to those before it, and is connected to by those behind.
  void meet_all() {
    for (int other = 0; other < number_; ++other) {
      const auto [address, size] = bare_place_of(meeting_, other);
      BareSocket socket(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
      while (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
        if (errno != ECONNREFUSED && errno != EAGAIN) give_up("a bare process is missing");
        take_some(kTryAgain);
      }
      greet(std::move(socket));
    }
    while (heard_ < count_ - 1) take_some(std::chrono::seconds(60));
  }

 private:
  void watch(int descriptor) const {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.fd = descriptor;
    ::epoll_ctl(all_.get(), EPOLL_CTL_ADD, descriptor, &event);
  }

  void greet(BareSocket socket) {
    const std::array<char, kHelloBytes> hello{};
    if (::send(socket.get(), hello.data(), hello.size(), MSG_NOSIGNAL) != kHelloBytes)
      give_up("a bare process is gone");
    watch(socket.get());
    open_.push_back(std::move(socket));
  }

  void take_some(std::chrono::milliseconds most) {
    std::array<epoll_event, 64> ready{};
    const auto count = ::epoll_wait(all_.get(), ready.data(), ready.size(), static_cast<int>(most.count()));
    if (count == 0 && most > kTryAgain) give_up("the bare processes do not meet");
    for (int i = 0; i < count; ++i) take(ready[static_cast<std::size_t>(i)].data.fd);
  }

  void take(int descriptor) {
    if (descriptor == listener_.get()) {
      BareSocket one(::accept4(descriptor, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
      if (one.get() >= 0) greet(std::move(one));
      return;
    }
    std::array<char, kHelloBytes> hello{};
    if (::recv(descriptor, hello.data(), hello.size(), 0) == kHelloBytes) ++heard_;
  }

  const Meeting& meeting_;
  int number_, count_, heard_ = 0;
  BareSocket all_{::epoll_create1(EPOLL_CLOEXEC)};
  BareSocket listener_{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)};
  std::vector<BareSocket> open_;
};

}  // namespace

/// All processes stay until the same time, as those of a crowd.
Json bare_member(const Meeting& meeting, const Json& options) {
  const double begin = options.at("begin"), stay = options.at("stay_s");
  BareMember member(meeting, options.at("number"), options.at("count"));
  member.meet_all();
  const auto seen = wall_seconds() - begin, used = own_processor_seconds();
  std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, stay - seen)));
  return {{"seen_s", seen}, {"meeting_cpu_s", used}};
}

}  // namespace rubicon::bench
