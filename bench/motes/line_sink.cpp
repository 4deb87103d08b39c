#include "motes/line_sink.h"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <deque>
#include <sstream>
#include <stdexcept>
#include <string>

#include "motes/framing.h"
#include "motes/mote_records.h"

namespace rubicon::bench::motes {

namespace {

using namespace std::chrono_literals;
using namespace rubicon::motes;

constexpr auto kByte = std::chrono::nanoseconds(86'806);  // 10 bits at 115200 baud
constexpr auto kAckDelay = 50ms;                          // wsn.md 2: 46 to 67 ms
constexpr std::size_t kPayload = 114;

Bytes frame_of(NetMessage message) {
  auto payload = encode_net(message);
  payload.resize(kPayload);
  return hdlc_packet(
      encode_packet({{kBroadcast, 0, kPayload, 0, static_cast<std::uint8_t>(AmType::kNetMessage)}, payload}));
}

/// What the child does: one connection, until it is closed.
class Line {
 public:
  Line(int socket, std::chrono::seconds readings) : socket_(socket), readings_(readings) {}

  void run() {
    while (true) {
      const auto wait = std::max<Clock::duration>(next_event() - Clock::now(), 0ns);
      const timespec pause{std::chrono::duration_cast<std::chrono::seconds>(wait).count(),
                           static_cast<long>((wait % 1s).count())};
      pollfd wanted{socket_, POLLIN, 0};
      const bool readable = ::ppoll(&wanted, 1, &pause, nullptr) > 0;
      if (readable && !read()) return;
      write_due();
    }
  }
  void report(FILE* to) const {
    std::fprintf(to, "%llu\n", static_cast<unsigned long long>(frames_));
    for (const auto& [what, at] : commands_)
      std::fprintf(to, "%d %d %lld\n", what.first, what.second, static_cast<long long>(at));
    std::fflush(to);
  }

 private:
  struct Due {
    Clock::time_point at;
    Bytes bytes;
  };

  Clock::time_point next_event() const {
    auto next = island_ == 0 ? Clock::now() + 1s : free_;
    if (!acks_.empty()) next = std::min(next, acks_.front().at);
    return next;
  }

  bool read() {
    std::array<std::uint8_t, 4096> buffer;
    const auto count = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (count <= 0) return false;
    const auto now = Clock::now();
    ByteView bytes(buffer.data(), static_cast<std::size_t>(count));
    // A command is one small write of the other side and arrives whole: first and last byte come together.
    while (const auto frame = reader_.next(bytes)) take(*frame, now);
    return true;
  }

  void take(const HdlcFrame& frame, Clock::time_point now) {
    if (frame.protocol != kHdlcAckedPacket) return;
    acks_.push_back({now + kAckDelay, hdlc_ack(frame.sequence)});
    const auto packet = decode_packet(frame.packet);
    if (!packet) return;
    if (packet->is(AmType::kConfig)) {
      if (const auto config = decode_config(packet->payload); config && island_ == 0) begin(config->value, now);
      return;
    }
    const auto net = decode_net(packet->payload);
    if (!net) return;
    const auto record = decode_record(*net);
    const auto* command = record ? std::get_if<ActuateCommand>(&*record) : nullptr;
    if (command != nullptr)
      commands_.try_emplace({net->destination_mote, command->value}, now.time_since_epoch().count());
    if (net->reliable != 0) acknowledge(*net);
  }

  void begin(std::uint16_t island, Clock::time_point now) {
    island_ = island;
    free_ = now;
    ends_ = now + readings_;
    for (std::uint16_t i = 0; i < LineSink::kMotes; ++i) {
      const auto mote = static_cast<std::uint16_t>(LineSink::kFirstMote + i);
      waiting_.push_back(message(mote, kTransportConnectionless, kApplicationControl,
                                 encode_record(Joined{island_, mote, 1, 0x1f4f, 1})));
    }
  }

  Bytes message(std::uint16_t mote, std::uint8_t transport, std::uint8_t application, const Bytes& record) {
    return frame_of({island_, kBaseMote, island_, mote, 0, ++sequence_, 112, transport, application, record});
  }

  void acknowledge(const NetMessage& asked) {
    base::ByteWriter record;
    record.u8(0x17).u16_be(asked.sequence).u8(0);
    waiting_.push_back(message(asked.destination_mote, kTransportAck, asked.application, record.take()));
  }

  /// One frame after the other, each after the last bit of the previous one.
  void write_due() {
    const auto now = Clock::now();
    if (island_ == 0) return;
    while (!acks_.empty() && acks_.front().at <= now && free_ <= now) {
      put(acks_.front().bytes);
      acks_.pop_front();
    }
    while (free_ <= now) {
      if (!waiting_.empty()) {
        put(waiting_.front());
        waiting_.pop_front();
      } else if (now < ends_) {
        put(reading());
        ++frames_;
      } else {
        free_ = now + 5ms;
      }
    }
  }
  Bytes reading() {
    const auto mote = static_cast<std::uint16_t>(LineSink::kFirstMote + frames_ % LineSink::kMotes);
    const auto light = static_cast<std::uint16_t>(frames_);
    RawUpdates updates;  // of DEMO_DATA only reports after a command would count
    updates.readings.push_back({static_cast<std::uint16_t>(Transducer::kLight), {light}});
    updates.readings.push_back({static_cast<std::uint16_t>(Transducer::kTemperature), {6500}});
    return message(mote, kTransportConnectionless, kApplicationControl, encode_record(updates));
  }
  void put(const Bytes& bytes) {
    if (::send(socket_, bytes.data(), bytes.size(), 0) < 0) ends_ = {};
    free_ += kByte * static_cast<int>(bytes.size());
  }

  int socket_;
  std::chrono::seconds readings_;
  HdlcReader reader_;
  std::uint16_t island_ = 0, sequence_ = 0;
  Clock::time_point free_{}, ends_{};
  std::deque<Due> acks_;
  std::deque<Bytes> waiting_;
  std::uint64_t frames_ = 0;
  decltype(LineSeen::commands) commands_;
};

int listening(std::uint16_t& port) {
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  if (::bind(socket, reinterpret_cast<sockaddr*>(&at), size) != 0 || ::listen(socket, 1) != 0 ||
      ::getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size) != 0)
    throw std::runtime_error("a port of loopback cannot be had");
  port = ntohs(at.sin_port);
  return socket;
}

}  // namespace

LineSink::LineSink(std::chrono::seconds readings) {
  const int socket = listening(port_);
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw std::runtime_error("pipe");
  child_ = ::fork();
  if (child_ == 0) {
    const int connection = ::accept(socket, nullptr, nullptr);
    const int yes = 1;
    ::setsockopt(connection, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    Line line(connection, readings);
    line.run();
    line.report(::fdopen(ends[1], "w"));
    ::_exit(0);
  }
  ::close(socket);
  ::close(ends[1]);
  report_ = ends[0];
}

LineSink::~LineSink() {
  if (report_ >= 0) ::close(report_);
  if (child_ < 0) return;
  ::kill(child_, SIGKILL);
  ::waitpid(child_, nullptr, 0);
}

LineSeen LineSink::seen() {
  std::string text;
  std::array<char, 4096> buffer;
  for (ssize_t count; (count = ::read(report_, buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(count));
  LineSeen seen;
  std::istringstream lines(text);
  lines >> seen.frames;
  int mote = 0, value = 0;
  for (std::int64_t at = 0; lines >> mote >> value >> at;) seen.commands[{mote, value}] = at;
  return seen;
}

}  // namespace rubicon::bench::motes
