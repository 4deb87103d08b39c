#include "support/memory/memory_serial.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/assert.h"
#include "support/memory/memory_arrival.h"

namespace rubicon::transport {

/// The device's or the program's end; `peer` exists while both do.
struct MemorySerial::End {
  SerialOptions options;
  bool device = false;
  StreamCallbacks calls;
  std::weak_ptr<End> peer;
  Bytes queue, kept;  ///< kept = arrived while held
  bool alive = true, connected = false, lost = false, held = false, flushing = false;
};

class MemoryLine final : public ByteStream {
 public:
  MemoryLine(MemorySerial& lines, MemorySerial::EndPtr end) : lines_(lines), end_(std::move(end)) {}
  ~MemoryLine() override { lines_.close(end_); }
  MemoryLine(const MemoryLine&) = delete;
  MemoryLine& operator=(const MemoryLine&) = delete;

  Result<void> send(ByteView bytes) override { return lines_.send(end_, bytes); }
  void hold(bool held) override { lines_.hold(end_, held); }
  std::size_t queued() const override { return end_->queue.size(); }

 private:
  MemorySerial& lines_;
  MemorySerial::EndPtr end_;
};

MemorySerial::MemorySerial(Scheduler& scheduler) : scheduler_(scheduler) {}
MemorySerial::~MemorySerial() = default;

std::unique_ptr<ByteStream> MemorySerial::make(const EndPtr& end, StreamCallbacks calls) {
  end->calls = std::move(calls);
  scheduler_.post([this, end] {
    if (!end->alive || end->lost) return;
    end->connected = true;
    flush(end);
    if (end->calls.connected) end->calls.connected();
  });
  return std::make_unique<MemoryLine>(*this, end);
}

std::unique_ptr<ByteStream> MemorySerial::plug(const std::string& path, StreamCallbacks calls) {
  RUBICON_ASSERT(!is_plugged(path));
  const auto device = std::make_shared<End>();
  device->options.path = path;
  device->device = true;
  devices_[path] = device;
  return make(device, std::move(calls));
}

const SerialOptions* MemorySerial::opened(const std::string& path) const {
  const auto device = devices_.find(path);
  const auto program = device == devices_.end() ? nullptr : device->second->peer.lock();
  return program ? &program->options : nullptr;
}

Result<std::unique_ptr<ByteStream>> MemorySerial::open(const SerialOptions& options, StreamCallbacks calls) {
  const auto& path = options.path;
  if (!is_baud_rate(options.baud))
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} baud is not a rate of serial lines", path, options.baud));
  const auto device = devices_.find(path);
  if (device == devices_.end()) return fail(ErrorCode::kNotFound, path + ": cannot open: No such file or directory");
  if (opened(path) != nullptr)
    return fail(ErrorCode::kBusy, path + ": cannot open: another program has the serial line");
  const auto program = std::make_shared<End>();
  program->options = options;
  program->peer = device->second;
  device->second->peer = program;
  return make(program, std::move(calls));
}

Result<void> MemorySerial::send(const EndPtr& end, ByteView bytes) {
  const auto& path = end->options.path;
  if (end->lost) return fail(ErrorCode::kUnreachable, path + ": cannot send: the connection is lost");
  const auto waits = end->queue.size();
  if (waits + bytes.size() > ByteStream::kMaxQueued)
    return fail(ErrorCode::kBusy, fmt::format("{}: cannot send {} bytes: {} wait already", path, bytes.size(), waits));
  end->queue.insert(end->queue.end(), bytes.begin(), bytes.end());
  if (std::exchange(end->flushing, true)) return {};
  scheduler_.post([this, end] {
    end->flushing = false;
    if (end->alive) flush(end);
  });
  return {};
}

void MemorySerial::flush(const EndPtr& end) {
  const auto peer = end->peer.lock();
  if (!end->connected || (peer && peer->held) || end->queue.empty()) return;
  auto bytes = std::exchange(end->queue, {});
  if (!peer) return;  // not open
  const auto flight = ++last_flight_;
  flights_[flight] = scheduler_.after(transit, [this, flight, peer, bytes = std::move(bytes)] {
    const auto landed = std::move(flights_.extract(flight).mapped());
    arrive_at(*peer, bytes, segment);
  });
}

void MemorySerial::hold(const EndPtr& end, bool held) {
  if (std::exchange(end->held, held) == held || held) return;
  scheduler_.post([this, end] {
    if (end->held) return;
    const auto kept = std::exchange(end->kept, {});
    arrive_at(*end, kept, segment);
    if (const auto peer = end->peer.lock(); peer && peer->alive) flush(peer);
  });
}

void MemorySerial::close(const EndPtr& end) {
  flush(end);
  end->alive = false;
  const auto peer = end->peer.lock();
  if (peer) peer->peer.reset();
  end->peer.reset();
  if (!end->device) return;
  devices_.erase(end->options.path);
  if (peer) scheduler_.post([this, peer] { lose(peer); });
}

void MemorySerial::lose(const EndPtr& end) {
  if (!end->alive || std::exchange(end->lost, true)) return;
  end->queue.clear();
  if (end->calls.failed) end->calls.failed({ErrorCode::kUnreachable, end->options.path + ": unplugged or closed"});
}

}  // namespace rubicon::transport
