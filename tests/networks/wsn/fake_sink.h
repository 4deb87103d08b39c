#pragma once

#include <deque>
#include <vector>

#include "base/virtual_scheduler.h"
#include "motes/mote_records.h"
#include "networks/wsn/outgoing.h"

namespace rubicon::networks::wsn {

/// Keeps what is sent to a sink; the test sets the result.
struct FakeSink {
  explicit FakeSink(VirtualScheduler& scheduler) : time(scheduler) {}

  MoteRequests::SendCall call() {
    return [this](sink::Outgoing packet) -> Result<void> {
      if (full) return fail(ErrorCode::kBusy, "full");
      sent.push_back(std::move(packet));
      if (!answers) return {};
      time.post([done = sent.back().done, outcome = outcome] { done(outcome); });
      return {};
    };
  }
  /// The radio message of the nth packet; its record is a view of that packet.
  motes::NetMessage message(std::size_t n) const {
    return motes::decode_net(motes::decode_packet(sent.at(n).packet)->payload).value();
  }
  motes::Record record(std::size_t n) const { return motes::decode_record(message(n)).value(); }
  motes::HeardAck ack(std::size_t n) const {
    const auto one = message(n);
    return {one.destination_mote, one.application, {one.sequence, 0}};
  }

  VirtualScheduler& time;
  std::vector<sink::Outgoing> sent;
  bool answers = true, full = false;
  sink::SendResult outcome = sink::SendResult::kAcknowledged;
};

}  // namespace rubicon::networks::wsn
