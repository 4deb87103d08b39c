#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "components/windows.h"
#include "ecology/measurements.h"

namespace rubicon::bench {

namespace {

constexpr std::size_t kSize = 64;
constexpr auto kRetry = std::chrono::milliseconds(5);

sockaddr_un address_of(const Meeting& meeting) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto path = std::string(std::getenv("RUBICON_FOLDER")) + "/" + meeting.tag;
  path.copy(static_cast<char*>(address.sun_path), sizeof address.sun_path - 1);
  return address;
}

/// False: the other end is gone.
bool pass(int socket, std::array<char, kSize>& bytes, bool write) {
  for (std::size_t done = 0; done < kSize;) {
    const auto count = write ? ::send(socket, bytes.data() + done, kSize - done, MSG_NOSIGNAL)
                             : ::recv(socket, bytes.data() + done, kSize - done, 0);
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace

Json bare_pong(const Meeting& meeting, const Json&) {
  const auto address = address_of(meeting);
  const int listener = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(listener, 1) != 0)
    give_up("no bare socket");
  const int socket = ::accept(listener, nullptr, nullptr);
  std::array<char, kSize> bytes{};
  while (pass(socket, bytes, false) && pass(socket, bytes, true)) continue;
  ::unlink(static_cast<const char*>(address.sun_path));
  return Json::object();
}

Json bare_ping(const Meeting& meeting, const Json& options) {
  const auto address = address_of(meeting);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  while (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    std::this_thread::sleep_for(kRetry);
  const auto pace = std::chrono::microseconds(options.at("pace_us").get<int>());
  const auto seconds = options.at("seconds").get<double>() + 1;
  std::array<char, kSize> bytes{};
  Windows windows;
  auto now = std::chrono::steady_clock::now();
  windows.begin(now);
  while (windows.seconds(now) <= seconds) {
    const auto sent = std::chrono::steady_clock::now();
    if (!pass(socket, bytes, true) || !pass(socket, bytes, false)) give_up("the other end of the bare stream is gone");
    now = std::chrono::steady_clock::now();
    windows.add(sent, now);
    if (pace.count() > 0) std::this_thread::sleep_until(sent + pace);
  }
  ::close(socket);
  return windows.json();
}

}  // namespace rubicon::bench
