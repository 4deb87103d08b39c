#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "transport/asio_traffic.h"
#include "transport/descriptor_watch.h"
#include "transport/machine_sockets.h"
#include "transport/sockets.h"

namespace rubicon::transport {

/// The constant of termios for a baud rate; nullopt if there is none (termios(3), asm-generic/termbits.h).
std::optional<speed_t> speed_of(unsigned baud);

namespace {

constexpr std::array<std::pair<unsigned, speed_t>, 30> kRates{
    {{50, B50},           {75, B75},           {110, B110},         {134, B134},         {150, B150},
     {200, B200},         {300, B300},         {600, B600},         {1200, B1200},       {1800, B1800},
     {2400, B2400},       {4800, B4800},       {9600, B9600},       {19200, B19200},     {38400, B38400},
     {57600, B57600},     {115200, B115200},   {230400, B230400},   {460800, B460800},   {500000, B500000},
     {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
     {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000}, {4000000, B4000000}}};

}  // namespace

std::optional<speed_t> speed_of(unsigned baud) {
  const auto found = std::find_if(kRates.begin(), kRates.end(), [&](const auto& rate) { return rate.first == baud; });
  return found == kRates.end() ? std::nullopt : std::optional(found->second);
}

bool is_baud_rate(unsigned baud) {
  return speed_of(baud).has_value();
}

namespace {

namespace asio = boost::asio;
using asio::posix::stream_descriptor;
using Line = AsioTraffic<stream_descriptor>;

auto cannot(const std::string& path, std::string_view doing, int error, ErrorCode code = ErrorCode::kIo) {
  return fail(code, fmt::format("{}: cannot {}: {}", path, doing, std::generic_category().message(error)));
}

/// The slave of a Unix98 pseudo-terminal (Linux, Documentation/admin-guide/devices.txt: character devices 136 to 143).
bool is_pseudo(const struct stat& status) {
  const auto number = major(status.st_rdev);
  return S_ISCHR(status.st_mode) && number >= 136 && number <= 143;
}

/// 8 data bits, 1 stop bit, no parity, no flow control, no echo, nothing translated. Modem lines are ignored, and
/// stay as they are when the line is closed: some boards reset on DTR or RTS (termios(3), HUPCL).
bool make_raw(int descriptor, std::optional<speed_t> speed) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB | HUPCL);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;  // with 0 an empty buffer would look like the end
  settings.c_cc[VTIME] = 0;
  if (speed) ::cfsetspeed(&settings, *speed);
  return ::tcsetattr(descriptor, TCSANOW, &settings) == 0;
}

/// Keeps other programs from opening the line. A pseudo-terminal is only locked: TIOCEXCL would stay in force after
/// this process was killed, because its maker has it open too.
Result<void> claim(const std::string& path, int descriptor, bool pseudo) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return fail(ErrorCode::kBusy, path + ": cannot open: another program has the serial line");
  if (!pseudo) ::ioctl(descriptor, TIOCEXCL);
  return {};
}

Result<OwnDescriptor> open_line(const SerialOptions& options, bool& pseudo) {
  const auto& path = options.path;
  const auto speed = speed_of(options.baud);
  if (!speed)
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} baud is not a rate of serial lines, expected one of termios, "
                                                 "such as 57600 or 115200",
                                                 path, options.baud));
  if (path.find('\0') != std::string::npos) return fail(ErrorCode::kNotFound, "a path with a zero byte in it");
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0)
    return cannot(path, "open", errno, errno == ENOENT || errno == ENOTDIR ? ErrorCode::kNotFound : ErrorCode::kIo);
  if (!S_ISCHR(status.st_mode)) return fail(ErrorCode::kInvalid, path + ": is not a serial line");
  pseudo = is_pseudo(status);
  OwnDescriptor line(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (line.get() < 0) {
    const bool gone = errno == ENOENT || errno == ENXIO || errno == ENODEV;
    const auto code = errno == EBUSY ? ErrorCode::kBusy : gone ? ErrorCode::kNotFound : ErrorCode::kIo;
    return cannot(path, "open", errno, code);
  }
  if (::isatty(line.get()) == 0) return fail(ErrorCode::kInvalid, path + ": is not a serial line");
  if (auto ours = claim(path, line.get(), pseudo); !ours) return fail(ours.error());
  if (!make_raw(line.get(), speed)) return cannot(path, fmt::format("set to {} baud", options.baud), errno);
  ::tcflush(line.get(), TCIFLUSH);
  return line;
}

/// Starts reading; `connected` is called in a later turn.
Result<void> start(const std::shared_ptr<Line>& line, OwnDescriptor descriptor) {
  boost::system::error_code error;
  line->socket.assign(descriptor.get(), error);
  if (!error) descriptor.take();
  if (!error) line->socket.non_blocking(true, error);
  if (error) return fail(line->trouble("watch", error));
  asio::post(line->socket.get_executor(), [line] {
    if (line->going()) line->begin();
  });
  return {};
}

class AsioSerial final : public ByteStream {
 public:
  AsioSerial(std::shared_ptr<Line> line, bool pseudo) : line_(std::move(line)), pseudo_(pseudo) {}
  ~AsioSerial() override {
    // Otherwise close() waits up to half a minute until a slow line has sent the rest (tty(4), closing_wait).
    if (!pseudo_ && line_->socket.is_open()) ::tcflush(line_->socket.native_handle(), TCOFLUSH);
    line_->leave();
  }
  AsioSerial(const AsioSerial&) = delete;
  AsioSerial& operator=(const AsioSerial&) = delete;

  Result<void> send(ByteView bytes) override { return line_->send(bytes); }
  void hold(bool held) override { line_->hold(held); }
  std::size_t queued() const override { return line_->waits(); }

 private:
  std::shared_ptr<Line> line_;
  bool pseudo_;
};

/// Marks the slave of a pseudo-terminal as belonging to a running program. The lock ends with the program, and differs
/// from those that programs claim lines with (fcntl(2), open file description locks).
bool mark(int slave) {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  return ::fcntl(slave, F_OFD_SETLK, &lock) == 0;
}

/// Whether the program that made the slave runs; false for terminals made by other programs.
bool is_marked(const std::string& slave) {
  const OwnDescriptor line(::open(slave.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (line.get() < 0) return errno == EBUSY;
  struct flock lock {};
  lock.l_type = F_WRLCK;
  return ::fcntl(line.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

/// Owns the symbolic link to a pseudo-terminal.
class Link {
 public:
  Link(std::string path, std::string to) : path_(std::move(path)), to_(std::move(to)) {}
  ~Link() {
    if (made_ && target() == to_) ::unlink(path_.c_str());
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  Result<void> make() {
    if (path_.empty() || path_.find('\0') != std::string::npos)
      return fail(ErrorCode::kInvalid, "a path for a pseudo-terminal is empty or has a zero byte in it");
    if (const auto other = target(); other.starts_with("/dev/pts/")) {
      // A stale link may name the terminal that is ours now, because numbers are reused.
      if (other != to_ && is_marked(other))
        return fail(ErrorCode::kBusy, path_ + ": cannot make a pseudo-terminal: another program has one there");
      // A stale link: its terminal no longer exists, or belongs to another program.
      ::unlink(path_.c_str());
    }
    made_ = ::symlink(to_.c_str(), path_.c_str()) == 0;
    if (made_) return {};
    return cannot(path_, "make a link to " + to_, errno, errno == EEXIST ? ErrorCode::kDuplicate : ErrorCode::kIo);
  }

 private:
  /// Target of the present symbolic link; empty = there is none.
  std::string target() const {
    std::array<char, 256> text{};
    const auto size = ::readlink(path_.c_str(), text.data(), text.size());
    return size < 0 ? std::string() : std::string(text.data(), static_cast<std::size_t>(size));
  }

  std::string path_, to_;
  bool made_ = false;
};

class AsioPty final : public ByteStream {
 public:
  AsioPty(std::shared_ptr<Line> line, OwnDescriptor other_end, std::unique_ptr<Link> link)
      : line_(std::move(line)), other_end_(std::move(other_end)), link_(std::move(link)) {}
  ~AsioPty() override { line_->leave(); }
  AsioPty(const AsioPty&) = delete;
  AsioPty& operator=(const AsioPty&) = delete;

  Result<void> send(ByteView bytes) override { return line_->send(bytes); }
  void hold(bool held) override { line_->hold(held); }
  std::size_t queued() const override { return line_->waits(); }

 private:
  std::shared_ptr<Line> line_;
  OwnDescriptor other_end_;  ///< kept open, because reading from the master fails while no slave is open
  std::unique_ptr<Link> link_;
};

}  // namespace

Result<std::unique_ptr<ByteStream>> open_asio_serial(const asio::any_io_executor& executor,
                                                     const SerialOptions& options, StreamCallbacks calls) {
  bool pseudo = false;
  auto descriptor = open_line(options, pseudo);
  if (!descriptor) return fail(descriptor.error());
  auto line = std::make_shared<Line>(executor, options.path, "unplugged or closed", std::move(calls));
  auto stream = std::make_unique<AsioSerial>(line, pseudo);
  if (auto started = start(line, std::move(*descriptor)); !started) return fail(started.error());
  return stream;
}

Result<std::unique_ptr<ByteStream>> make_asio_pty(const asio::any_io_executor& executor, const std::string& link,
                                                  StreamCallbacks calls) {
  OwnDescriptor master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  std::array<char, 128> name{};
  if (master.get() < 0 || ::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0)
    return cannot(link, "make a pseudo-terminal", errno);
  if (const int error = ::ptsname_r(master.get(), name.data(), name.size()); error != 0)
    return cannot(link, "make a pseudo-terminal", error);
  OwnDescriptor slave(::open(name.data(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (slave.get() < 0 || !make_raw(slave.get(), std::nullopt) || !mark(slave.get()))
    return cannot(link, "make a pseudo-terminal", errno);
  auto named = std::make_unique<Link>(link, name.data());
  if (auto made = named->make(); !made) return fail(made.error());
  auto line = std::make_shared<Line>(executor, link, "the pseudo-terminal is lost", std::move(calls));
  if (auto started = start(line, std::move(master)); !started) return fail(started.error());
  return std::make_unique<AsioPty>(std::move(line), std::move(slave), std::move(named));
}

}  // namespace rubicon::transport
