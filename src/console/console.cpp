#include "console/console.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

namespace rubicon::console {

namespace asio = boost::asio;

namespace {

/// A pipe that poll calls writable takes this much without blocking (POSIX: PIPE_BUF).
constexpr std::size_t kChunk = 4096;

/// A pipe or terminal opened once more, so that it can be made non-blocking for us alone; else (sockets, terminals of
/// another user) a duplicate.
int reopened(int descriptor, int access) {
  struct stat about {};
  if (::fstat(descriptor, &about) == 0 && (S_ISFIFO(about.st_mode) || ::isatty(descriptor))) {
    const auto path = "/proc/self/fd/" + std::to_string(descriptor);
    const int fresh = ::open(path.c_str(), access | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (fresh >= 0) return fresh;
  }
  return ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
}

/// A descriptor one can wait for; regular files and /dev/null are always ready and epoll does not take them.
class Waiter {
 public:
  Waiter(asio::io_context& context, int descriptor, int access)
      : context_(context), descriptor_(reopened(descriptor, access)) {
    struct stat about {};
    const bool known = ::fstat(descriptor, &about) == 0;
    const bool always = !known || S_ISREG(about.st_mode) || (S_ISCHR(about.st_mode) && !::isatty(descriptor));
    if (!always && descriptor_ >= 0) stream_.emplace(context, descriptor_);
  }
  ~Waiter() {
    if (!stream_ && descriptor_ >= 0) ::close(descriptor_);
  }
  Waiter(const Waiter&) = delete;
  Waiter& operator=(const Waiter&) = delete;

  int descriptor() const { return descriptor_; }

  template <class Call>
  void wait(asio::posix::stream_descriptor::wait_type what, Call call) {
    if (!stream_) return asio::post(context_, [call] { call(true); });
    stream_->async_wait(what, [call](const boost::system::error_code& error) { call(!error); });
  }

 private:
  asio::io_context& context_;
  int descriptor_;
  std::optional<asio::posix::stream_descriptor> stream_;
};

}  // namespace

struct ConsoleWriter::Impl : std::enable_shared_from_this<ConsoleWriter::Impl> {
  Impl(asio::io_context& context, int descriptor, std::function<void()> on_closed)
      : waiter(context, descriptor, O_WRONLY), closed(std::move(on_closed)) {}

  void put(std::string text) {
    if (broken) return;
    waiting_bytes += text.size();
    lines.push_back(std::move(text));
    wait();
  }

  void wait() {
    if (waiting || broken) return;
    waiting = true;
    waiter.wait(asio::posix::stream_descriptor::wait_write, [weak = weak_from_this()](bool ready) {
      const auto self = weak.lock();
      if (!self) return;
      self->waiting = false;
      if (ready) self->write();
    });
  }

  void fill() {
    current.clear();
    offset = 0;
    while (!lines.empty() && (current.empty() || current.size() + lines.front().size() <= kChunk)) {
      current += lines.front();
      waiting_bytes -= lines.front().size();
      lines.pop_front();
    }
  }

  void write() {
    if (offset == current.size()) fill();
    const auto piece = std::string_view(current).substr(offset, kChunk);
    const auto written = ::write(waiter.descriptor(), piece.data(), piece.size());
    if (written < 0 && errno != EINTR && errno != EAGAIN) return breaks();
    offset += static_cast<std::size_t>(std::max<ssize_t>(written, 0));
    if (!empty()) return wait();
    if (emptied) std::exchange(emptied, nullptr)();
  }

  void breaks() {
    broken = true;
    lines.clear();
    waiting_bytes = 0;
    current.clear();
    offset = 0;
    closed();
  }

  bool empty() const { return lines.empty() && offset == current.size(); }

  Waiter waiter;
  std::function<void()> closed, emptied;
  std::deque<std::string> lines;
  std::size_t waiting_bytes = 0;  ///< of the lines
  std::string current;            ///< being written, up to `offset`
  std::size_t offset = 0;
  bool waiting = false, broken = false;
  std::uint64_t dropped = 0;
};

ConsoleWriter::ConsoleWriter(asio::io_context& context, int descriptor, std::function<void()> closed)
    : impl_(std::make_shared<Impl>(context, descriptor, std::move(closed))) {}
ConsoleWriter::~ConsoleWriter() = default;

bool ConsoleWriter::event(std::string line) {
  if (impl_->lines.size() >= kMaxLines || impl_->waiting_bytes >= kMaxBytes) {
    ++impl_->dropped;
    return false;
  }
  answer(std::move(line));
  return true;
}

void ConsoleWriter::answer(std::string line) {
  line += '\n';
  impl_->put(std::move(line));
}

bool ConsoleWriter::crowded() const {
  return impl_->lines.size() >= kMaxLines / 2 || impl_->waiting_bytes >= kMaxBytes / 2;
}
bool ConsoleWriter::empty() const {
  return impl_->empty();
}
std::uint64_t ConsoleWriter::dropped() const {
  return impl_->dropped;
}

void ConsoleWriter::when_empty(std::function<void()> call) {
  if (impl_->empty() || impl_->broken) return call();
  impl_->emptied = std::move(call);
}

struct ConsoleReader::Impl : std::enable_shared_from_this<ConsoleReader::Impl> {
  Impl(asio::io_context& context, int descriptor, std::size_t longest, Callbacks some_calls)
      : waiter(context, descriptor, O_RDONLY), timer(context), max_line(longest), calls(std::move(some_calls)) {}

  void next() {
    if (calls.pause()) return pause();
    waiter.wait(asio::posix::stream_descriptor::wait_read, [weak = weak_from_this()](bool ready) {
      if (const auto self = weak.lock(); self && ready) self->read();
    });
  }

  void pause() {
    timer.expires_after(std::chrono::milliseconds(10));
    timer.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
      if (const auto self = weak.lock(); self && !error) self->next();
    });
  }

  void read() {
    std::array<char, kChunk> buffer;
    const auto count = ::read(waiter.descriptor(), buffer.data(), buffer.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) return next();
    if (count <= 0) {
      if (!partial.empty()) take_line();
      return calls.end();
    }
    const auto keep = shared_from_this();  // a line may end everything
    for (const char c : std::string_view(buffer.data(), static_cast<std::size_t>(count))) take(c);
    next();
  }

  void take(char c) {
    if (c == '\n') return take_line();
    if (partial.size() < max_line) {
      partial += c;
    } else {
      overlong = true;
    }
  }

  void take_line() {
    const auto line = std::exchange(partial, {});
    if (std::exchange(overlong, false)) return calls.too_long();
    calls.line(line);
  }

  Waiter waiter;
  asio::steady_timer timer;
  std::size_t max_line;
  Callbacks calls;
  std::string partial;
  bool overlong = false;
};

ConsoleReader::ConsoleReader(asio::io_context& context, int descriptor, std::size_t max_line, Callbacks calls)
    : impl_(std::make_shared<Impl>(context, descriptor, max_line, std::move(calls))) {
  impl_->next();
}
ConsoleReader::~ConsoleReader() = default;

}  // namespace rubicon::console
