#include "support/memory/memory_tcp.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "support/memory/memory_arrival.h"
#include "support/memory/memory_udp.h"

namespace rubicon::transport {

/// One end of a connection; `alive` = its stream exists.
struct MemoryTcp::End {
  Endpoint local, remote;
  TcpCallbacks calls;
  std::weak_ptr<End> peer;
  Bytes queue;
  std::size_t in_flight = 0;  ///< bytes that left the queue and have not arrived
  Bytes kept;                 ///< arrived while held
  bool held = false;
  bool connected = false, lost = false, alive = true, flushing = false;
  Timer deadline;
};

class MemoryStream final : public TcpStream {
 public:
  MemoryStream(MemoryTcp& net, MemoryTcp::EndPtr end) : net_(net), end_(std::move(end)) {}
  ~MemoryStream() override { net_.close(end_); }
  MemoryStream(const MemoryStream&) = delete;
  MemoryStream& operator=(const MemoryStream&) = delete;

  Result<void> send(ByteView bytes) override {
    const auto name = to_string(end_->remote);
    if (end_->lost)
      return fail(ErrorCode::kUnreachable, fmt::format("TCP {}: cannot send: the connection is lost", name));
    if (end_->queue.size() + bytes.size() > kMaxQueued) net_.flush(end_);
    const auto waits = end_->queue.size();
    if (waits + bytes.size() > kMaxQueued)
      return fail(ErrorCode::kBusy,
                  fmt::format("TCP {}: cannot send {} bytes: {} wait already", name, bytes.size(), waits));
    end_->queue.insert(end_->queue.end(), bytes.begin(), bytes.end());
    if (!std::exchange(end_->flushing, true)) {
      net_.scheduler_.post([net = &net_, end = end_] {
        end->flushing = false;
        if (end->alive) net->flush(end);
      });
    }
    return {};
  }
  void abort() override {
    end_->queue.clear();
    net_.close(end_);
    end_->lost = true;
    end_->connected = false;
  }
  void hold(bool held) override { net_.hold(end_, held); }
  std::size_t queued() const override { return end_->queue.size(); }
  bool connected() const override { return end_->connected; }
  std::size_t unacknowledged() const override { return end_->lost ? 0 : end_->queue.size() + end_->in_flight; }
  Endpoint local() const override { return end_->connected ? end_->local : Endpoint{}; }
  Endpoint remote() const override { return end_->connected ? end_->remote : Endpoint{}; }

 private:
  MemoryTcp& net_;
  MemoryTcp::EndPtr end_;
};

class MemoryListening final : public MemoryListener {
 public:
  MemoryListening(MemoryTcp& net, Endpoint at) : net_(net), at_(std::move(at)) {}
  ~MemoryListening() override { net_.listeners_.erase(at_); }
  MemoryListening(const MemoryListening&) = delete;
  MemoryListening& operator=(const MemoryListening&) = delete;

 private:
  MemoryTcp& net_;
  Endpoint at_;
};

class MemoryPort final : public TcpListener {
 public:
  MemoryPort(std::unique_ptr<MemoryListener> listener, Endpoint local, std::shared_ptr<const ListenerFailed> failed)
      : listener_(std::move(listener)), local_(std::move(local)), failed_(std::move(failed)) {}
  Endpoint local() const override { return local_; }

 private:
  std::unique_ptr<MemoryListener> listener_;
  Endpoint local_;
  std::shared_ptr<const ListenerFailed> failed_;
};

MemoryTcp::MemoryTcp(Scheduler& scheduler) : scheduler_(scheduler) {}
MemoryTcp::~MemoryTcp() = default;

std::unique_ptr<MemoryListener> MemoryTcp::listen(const Endpoint& at, Accept accept) {
  RUBICON_ASSERT(!listeners_.contains(at));
  listeners_.emplace(at, Listening{std::move(accept), {}});
  return std::make_unique<MemoryListening>(*this, at);
}

Result<std::unique_ptr<TcpListener>> MemoryTcp::listen(const std::string& host, const Endpoint& local, Accept accept,
                                                       ListenerFailed failed) {
  if (local.address.empty() || !is_numeric_address(local.address))
    return fail(ErrorCode::kInvalid, fmt::format("TCP: no address to listen on: {}", to_string(local)));
  Endpoint at{host, local.port == 0 ? ++last_port_ : local.port};
  while (local.port == 0 && listeners_.contains(at)) at.port = ++last_port_;
  if (listeners_.contains(at))
    return fail(ErrorCode::kBusy, fmt::format("TCP {}: cannot listen: Address already in use", to_string(local)));
  auto listener = listen(at, std::move(accept));
  auto failed_call = std::make_shared<const ListenerFailed>(std::move(failed));
  listeners_[at].failed = failed_call;
  return std::make_unique<MemoryPort>(std::move(listener), Endpoint{local.address, at.port}, std::move(failed_call));
}

void MemoryTcp::fail_listeners() {
  for (const auto& [at, listening] : std::exchange(listeners_, {})) {
    scheduler_.post([at = at, failed = listening.failed] {
      const auto call = failed.lock();
      if (call && *call)
        (*call)({ErrorCode::kIo, fmt::format("TCP {}: cannot accept connections: gone", to_string(at))});
    });
  }
}

void MemoryTcp::stall(bool stalled) {
  stalled_ = stalled;
  for (const auto& end : std::vector<EndPtr>(ends_)) flush(end);
  if (stalled) return;
  for (const auto& end : std::exchange(closed_, {})) {
    flush(end);
    hang_up(end);
  }
}

void MemoryTcp::cut() {
  for (const auto& end : ends_) {
    scheduler_.post([this, end] {
      lose(end,
           {ErrorCode::kIo, fmt::format("TCP {}: cannot receive: Connection reset by peer", to_string(end->remote))});
    });
  }
}

std::size_t MemoryTcp::open_streams() const {
  return ends_.size();
}

Result<std::unique_ptr<TcpStream>> MemoryTcp::open(const std::string& host, const TcpOptions& options,
                                                   TcpCallbacks calls) {
  if (!is_numeric_address(options.remote.address) || options.remote.port == 0)
    return fail(ErrorCode::kInvalid, fmt::format("TCP: no endpoint: {}", to_string(options.remote)));
  const auto client = make_end({host, ++last_port_}, options.remote);
  client->calls = std::move(calls);
  if (answers) after_transit([this, client] { reach(client); });
  const auto waited = std::chrono::duration<double>(options.connect_timeout).count();
  client->deadline = scheduler_.after(options.connect_timeout, [this, client = client.get(), waited] {
    const auto found = std::find_if(ends_.begin(), ends_.end(), [&](const auto& end) { return end.get() == client; });
    if (found == ends_.end() || client->connected) return;
    lose(EndPtr(*found), {ErrorCode::kUnreachable, fmt::format("TCP {}: cannot connect: no answer within {} s",
                                                               to_string(client->remote), waited)});
  });
  return std::make_unique<MemoryStream>(*this, client);
}

MemoryTcp::EndPtr MemoryTcp::make_end(Endpoint local, Endpoint remote) {
  auto end = std::make_shared<End>();
  end->local = std::move(local);
  end->remote = std::move(remote);
  ends_.push_back(end);
  return end;
}

void MemoryTcp::after_transit(std::function<void()> call) {
  const auto flight = ++last_flight_;
  flights_[flight] = scheduler_.after(transit, [this, flight, call = std::move(call)] {
    const auto landed = std::move(flights_.extract(flight).mapped());
    call();
  });
}

std::map<Endpoint, MemoryTcp::Listening>::const_iterator MemoryTcp::listener_for(const End& client) const {
  const auto found = listeners_.find(client.remote);
  if (found != listeners_.end() || client.remote.address != "127.0.0.1") return found;
  return listeners_.find({client.local.address, client.remote.port});
}

void MemoryTcp::reach(const EndPtr& client) {
  if (!client->alive || client->lost) return;
  const auto listener = listener_for(*client);
  if (listener != listeners_.end()) return accept(client, Accept(listener->second.accept));
  lose(client,
       {ErrorCode::kUnreachable, fmt::format("TCP {}: cannot connect: Connection refused", to_string(client->remote))});
}

void MemoryTcp::accept(const EndPtr& client, const Accept& accept) {
  const auto server = make_end(client->remote, client->local);
  server->connected = true;
  server->peer = client;
  client->peer = server;
  after_transit([this, client] {
    if (!client->alive || client->lost) return;
    client->connected = true;
    client->deadline.cancel();
    flush(client);
    if (client->calls.connected) client->calls.connected();
  });
  server->calls = accept(std::make_unique<MemoryStream>(*this, server));
}

void MemoryTcp::flush(const EndPtr& end) {
  const auto peer = end->peer.lock();
  if (stalled_ || !end->connected || !peer || peer->held || end->queue.empty()) return;
  end->in_flight += end->queue.size();
  after_transit([this, end, peer, bytes = std::exchange(end->queue, {})] {
    end->in_flight -= bytes.size();
    arrive_at(*peer, bytes, segment);
  });
}

void MemoryTcp::hold(const EndPtr& end, bool held) {
  if (std::exchange(end->held, held) == held || held) return;
  scheduler_.post([this, end] {
    if (end->held) return;
    const auto kept = std::exchange(end->kept, {});
    arrive_at(*end, kept, segment);
    if (const auto peer = end->peer.lock(); peer && peer->alive) flush(peer);
  });
}

void MemoryTcp::lose(const EndPtr& end, Error why) {
  if (!end->alive || std::exchange(end->lost, true)) return;
  end->connected = false;
  end->queue.clear();
  end->deadline.cancel();
  std::erase(ends_, end);
  if (end->calls.failed) end->calls.failed(std::move(why));
}

void MemoryTcp::close(const EndPtr& end) {
  if (!end->alive) return;
  flush(end);
  end->alive = false;
  end->deadline.cancel();
  std::erase(ends_, end);
  if (!stalled_) return hang_up(end);
  if (!end->lost) closed_.push_back(end);
}

void MemoryTcp::hang_up(const EndPtr& end) {
  const auto peer = end->peer.lock();
  if (!peer || end->lost) return;
  after_transit([this, peer] {
    lose(peer, {ErrorCode::kUnreachable, fmt::format("TCP {}: the other end closed", to_string(peer->remote))});
  });
}

}  // namespace rubicon::transport
