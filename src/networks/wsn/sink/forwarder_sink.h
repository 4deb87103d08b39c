#pragma once

#include <memory>

#include "base/lifetime.h"
#include "motes/forwarder_stream.h"
#include "networks/wsn/sink/send_queue.h"
#include "networks/wsn/sink/sink_notifier.h"

namespace rubicon::networks::wsn::sink {

/// A sink behind a serial forwarder (Source::Kind kForwarder; wsn.md 4): up after the forwarder's greeting. The
/// protocol does not carry the sink's acknowledgements: packets keep a minimum gap, and count as acknowledged when they
/// are written.
class ForwarderSink final : public Sink {
 public:
  static constexpr Duration kMinGap = std::chrono::milliseconds(100);  ///< between packets (wsn.md 9.7)
  static constexpr Duration kGreetingTimeout = std::chrono::seconds(10);

  ForwarderSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports, SinkCallbacks callbacks);
  ForwarderSink(const ForwarderSink&) = delete;
  ForwarderSink& operator=(const ForwarderSink&) = delete;

  Result<void> open() override;
  Result<void> send(Outgoing packet) override { return queue_.push(std::move(packet)); }
  const SinkState& state() const override { return notifier_.state(); }
  std::map<std::string, std::uint64_t> counters() const override;

 private:
  void connected();
  void take(ByteView bytes);
  bool greeted();
  void pump();
  bool may_send();
  void written(Outgoing packet);
  void lost(Error why);

  Source source_;
  Bytes greeting_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  SendQueue queue_;
  std::unique_ptr<transport::ByteStream> line_;
  motes::ForwarderReader reader_;
  bool greeting_pending_ = false;  ///< the first packet on this line was not sent yet
  SteadyTime next_send_ = SteadyTime::min();
  Timer gap_, greeting_timeout_;
  std::uint64_t written_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
