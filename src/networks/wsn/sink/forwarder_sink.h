#pragma once

#include <memory>

#include "base/lifetime.h"
#include "motes/forwarder_stream.h"
#include "networks/wsn/sink/send_queue.h"
#include "networks/wsn/sink/sink_notifier.h"

namespace rubicon::networks::wsn::sink {

/// A sink that a serial forwarder has (Source::Kind kForwarder; wsn.md 4): up when the forwarder greeted. It tells
/// nothing of the sink's acks: packets keep a distance, and are acknowledged when handed over.
class ForwarderSink final : public Sink {
 public:
  static constexpr Duration kDistance = std::chrono::milliseconds(100);  ///< between packets (wsn.md 9.7)
  static constexpr Duration kGreetingTime = std::chrono::seconds(10);

  ForwarderSink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports, SinkCallbacks calls);
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
  void handed_over(Outgoing packet);
  void lost(Error why);

  Source source_;
  Bytes greeting_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  SinkNotifier notifier_;
  SendQueue queue_;
  std::unique_ptr<transport::ByteStream> line_;
  motes::ForwarderReader reader_;
  bool greeting_waits_ = false;  ///< the first packet on this line has not left
  SteadyTime next_ = SteadyTime::min();
  Timer pause_, greeting_time_;
  std::uint64_t handed_over_ = 0;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::networks::wsn::sink
