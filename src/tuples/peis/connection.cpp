#include "tuples/peis/connection.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tuples/peis/fields.h"

namespace rubicon::tuples::peis {

void PackageStream::append(ByteView bytes) {
  shed();
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

Result<std::optional<ConnectMessage>> PackageStream::connect() {
  if (fault_) return fail(*fault_);
  if (rest().size() < kConnectSize) return std::nullopt;
  auto message = read_connect(rest().first(kConnectSize));
  if (!message) {
    fault_ = message.error();
    return fail(*fault_);
  }
  begin_ += kConnectSize;
  return std::move(*message);
}

Result<std::optional<Package>> PackageStream::next() {
  if (fault_) return fail(*fault_);
  const auto bytes = rest();
  if (bytes.size() < kHeaderSize) return std::nullopt;
  const auto header = read_package_header(bytes);
  if (!header) {
    fault_ = header.error();
    return fail(*fault_);
  }
  const auto size = kHeaderSize + header->length;
  if (bytes.size() < size) return std::nullopt;
  begin_ += size;
  return Package{*header, bytes.subspan(kHeaderSize, header->length)};
}

namespace {

using namespace std::chrono_literals;

/// The system does not report when it took bytes. So the connection tries again after this time while it has more to
/// write.
constexpr Duration kWriteAgain = 2ms;
constexpr Duration kCheckProgress = 250ms;
/// Most bytes of one write in blocks.
constexpr std::size_t kWrite = 32 * 1024;
constexpr std::size_t kCounterAt = 8;  ///< in a package

}  // namespace

Connection::Connection(Scheduler& scheduler, ConnectionCallbacks calls)
    : scheduler_(scheduler),
      callbacks_(std::move(calls)),
      silence_(scheduler, [this] { check_silence(); }),
      quiet_(scheduler, [this] { check_quiet(); }),
      stuck_(scheduler, [this] { check_progress(); }),
      flush_(scheduler, [this] { write_block(); }) {}

Connection::~Connection() = default;

Result<void> Connection::dial(transport::Transports& transports, const transport::Endpoint& to,
                              const ConnectMessage& own) {
  own_ = own;
  remote_ = to;
  auto stream = transports.open_tcp({to, kConnectTime, kSilenceLimit, kRoutingPeriod}, stream_calls());
  if (!stream) return fail(stream.error());
  stream_ = std::move(*stream);
  return {};
}

transport::TcpCallbacks Connection::accept(std::unique_ptr<transport::TcpStream> stream) {
  stream_ = std::move(stream);
  remote_ = stream_->remote();
  state_ = State::kAccepting;
  heard_ = scheduler_.now();
  silence_.set(silence_limit_);
  return stream_calls();
}

transport::TcpCallbacks Connection::stream_calls() {
  transport::TcpCallbacks calls;
  calls.connected = lifetime_.guard([this] { established(); });
  calls.received = lifetime_.guard([this](ByteView bytes) { received(bytes); });
  calls.failed = lifetime_.guard([this](Error error) { end(Ending::kFailed, std::move(error)); });
  return calls;
}

void Connection::established() {
  if (state_ != State::kConnecting) return;
  state_ = State::kOpen;
  heard_ = scheduler_.now();
  silence_.set(silence_limit_);
  if (!write(peis::write(own_))) return;
  callbacks_.connected();
}

void Connection::received(ByteView bytes) {
  if (state_ == State::kClosed) return;
  bytes_in_ += bytes.size();
  packages_.append(bytes);
  if (state_ == State::kAccepting && !take_connect()) return;
  heard_ = scheduler_.now();
  if (!wide_) silence_limit_ = kSilenceLimit;
  take_packages();
}

bool Connection::take_connect() {
  const auto message = packages_.connect();
  if (!message) return end(Ending::kStrange, message.error()), false;
  if (!*message) return false;
  state_ = State::kOpen;
  if (callbacks_.greeted(**message)) return state_ == State::kOpen;
  return end(Ending::kRefused, {ErrorCode::kRefused, "refused"}), false;
}

void Connection::take_packages() {
  while (state_ == State::kOpen) {
    const auto package = packages_.next();
    if (!package) return end(Ending::kStrange, package.error());
    if (!*package) return packages_.shed();
    callbacks_.package(**package);
  }
}

bool Connection::send(ByteView package, bool urgent) {
  if (state_ == State::kClosed) return true;  // lost with the connection
  if (wide_) {
    if (block_.size() + package.size() > (urgent ? 2 * kMaxBlock : kMaxBlock)) {
      refused_ = true;
      return false;
    }
    block_.insert(block_.end(), package.begin(), package.end());
    const auto written = std::span(block_).last(package.size());
    put_u32(written, kCounterAt, counter_++);
    flush_.request();
    return true;
  }
  auto& queue = urgent ? urgent_ : normal_;
  if (queue.size() >= kMaxPackages) {
    refused_ = true;
    return false;
  }
  queue.emplace_back(package.begin(), package.end());
  if (!retry_.pending()) write();
  return true;
}

/// Writes packages to a kernel, one by one.
void Connection::write() {
  if (wide_) return write_block();
  while (state_ == State::kOpen && !failing_ && waiting() > 0) {
    if (write_next(urgent_.empty() ? normal_ : urgent_)) continue;
    retry_ = scheduler_.after(kWriteAgain, [this] { write(); });
    break;
  }
  tell_room();
}

bool Connection::write_next(std::deque<Bytes>& queue) {
  auto& package = queue.front();
  const bool passes = closing_ && &queue == &urgent_;  // goodbye: no lock-up can follow
  if (!passes && stream_->unacknowledged() + package.size() > kMaxUnacknowledgedBytes) return false;
  put_u32(package, kCounterAt, counter_);
  if (!write(package)) return failing_;
  ++counter_;
  queue.pop_front();
  return true;
}

void Connection::write_block() {
  std::size_t done = 0;
  while (state_ == State::kOpen && !failing_ && done < block_.size()) {
    const auto piece = ByteView(block_).subspan(done).first(std::min(kWrite, block_.size() - done));
    if (!write(piece)) break;
    done += piece.size();
  }
  base::drop_front(block_, done);
  if (!block_.empty() && !failing_ && !retry_.pending()) retry_ = scheduler_.after(kWriteAgain, [this] { write(); });
  tell_room();
}

/// False: the system takes nothing now, or the connection is lost, which the stream reports in a later turn.
bool Connection::write(ByteView bytes) {
  const auto sent = stream_->send(bytes);
  if (!sent) {
    failing_ = sent.error().code != ErrorCode::kBusy;
    if (failing_) lifetime_.post(scheduler_, [this, error = sent.error()] { end(Ending::kFailed, error); });
    return false;
  }
  bytes_out_ += bytes.size();
  if (!wide_) watch_progress();
  return true;
}

void Connection::tell_room() {
  if (!refused_ || failing_ || state_ != State::kOpen) return;
  if (wide_ ? block_.size() > kMaxBlock / 2 : normal_.size() > kMaxPackages / 2) return;
  refused_ = false;
  lifetime_.post(scheduler_, [this] {
    if (state_ == State::kOpen) callbacks_.room();
  });
}

void Connection::watch_progress() {
  if (stuck_.is_set()) return;
  progress_ = scheduler_.now();
  acknowledged_ = bytes_out_ - std::min<std::uint64_t>(bytes_out_, stream_->unacknowledged());
  stuck_.set(kCheckProgress);
}

/// A kernel's stream can lock up for good (section 6.2, 13).
void Connection::check_progress() {
  if (state_ != State::kOpen || wide_) return;
  const auto waits = stream_->unacknowledged();
  if (waits == 0 && waiting() == 0) return;
  const auto acknowledged = bytes_out_ - std::min<std::uint64_t>(bytes_out_, waits);
  if (std::exchange(acknowledged_, acknowledged) != acknowledged) progress_ = scheduler_.now();
  if (scheduler_.now() - progress_ < kStuckTime) return stuck_.set(kCheckProgress);
  end(Ending::kStuck, {ErrorCode::kUnreachable,
                       fmt::format("TCP {}: no byte was acknowledged for 2 s", transport::to_string(remote_))});
}

void Connection::check_silence() {
  const auto over = heard_ + silence_limit_;
  if (over > scheduler_.now()) return silence_.set_at(over);
  end(Ending::kSilent,
      {ErrorCode::kUnreachable, fmt::format("TCP {}: nothing came for {} s", transport::to_string(remote_),
                                            std::chrono::duration<double>(silence_limit_).count())});
}

void Connection::check_quiet() {
  if (state_ != State::kOpen) return;
  quiet_.set(quiet_limit_);
  if (out_when_checked_ == bytes_out_ + block_.size()) callbacks_.quiet();
  out_when_checked_ = bytes_out_ + block_.size();
}

void Connection::widen(Duration lease, Duration own_lease) {
  if (state_ != State::kOpen) return;
  silence_limit_ = lease;
  quiet_limit_ = own_lease / 3;
  silence_.set(silence_limit_);
  quiet_.set(quiet_limit_);
  if (std::exchange(wide_, true)) return;
  stuck_.clear();
  for (auto* queue : {&urgent_, &normal_}) {
    for (auto& package : std::exchange(*queue, {})) {
      put_u32(package, kCounterAt, counter_++);
      block_.insert(block_.end(), package.begin(), package.end());
    }
  }
  flush_.request();
}

void Connection::close() {
  if (state_ == State::kOpen && !failing_) {
    closing_ = true;
    while (waiting() > 0 && !failing_ && write_next(urgent_.empty() ? normal_ : urgent_)) {
    }
    write_block();
  }
  state_ = State::kClosed;
  retry_.cancel();
  silence_.clear();
  quiet_.clear();
  stuck_.clear();
  lifetime_.end();
  stream_.reset();
}

void Connection::end(Ending why, Error error) {
  if (state_ == State::kClosed) return;
  if (why == Ending::kStuck || why == Ending::kSilent) stream_->abort();
  failing_ = true;
  const auto closed = callbacks_.closed;
  close();
  closed(why, std::move(error));
}

IdCheck::IdCheck(Scheduler& scheduler, transport::Transports& transports, ConnectMessage own,
                 std::function<void(const Identity&)> confirmed)
    : scheduler_(scheduler),
      transports_(transports),
      own_(std::move(own)),
      confirmed_(std::move(confirmed)),
      cleaning_(scheduler,
                [this] { std::erase_if(questions_, [](const auto& item) { return item.second.is_over; }); }) {}

void IdCheck::ask(const Identity& other, const std::vector<transport::Endpoint>& addresses) {
  for (const auto& [id, question] : questions_) {
    if (question.other.magic == other.magic) return;
  }
  for (const auto& address : addresses) {
    if (questions_.size() < kMaxQuestions) ask(other, address);
  }
}

void IdCheck::ask(const Identity& other, const transport::Endpoint& address) {
  const auto id = ++last_;
  auto& question = questions_[id];
  question.other = other;
  ConnectionCallbacks calls;
  calls.connected = [this, id] { questions_.at(id).is_connected = true; };
  calls.greeted = [](const ConnectMessage&) { return false; };
  calls.package = [this, id](const Package& package) { end(id, package.header.source == own_.id); };
  calls.closed = [this, id](Ending why, const Error&) {
    end(id, why == Ending::kFailed && questions_.at(id).is_connected);
  };
  calls.room = calls.quiet = [] {};
  question.connection = std::make_unique<Connection>(scheduler_, std::move(calls));
  if (!question.connection->dial(transports_, address, own_)) questions_.erase(id);
}

void IdCheck::end(std::uint64_t id, bool is_there) {
  auto& question = questions_.at(id);
  if (std::exchange(question.is_over, true)) return;
  question.connection->close();
  cleaning_.request();
  if (is_there) confirmed_(question.other);
}

}  // namespace rubicon::tuples::peis
