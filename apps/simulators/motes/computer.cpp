#include "apps/simulators/motes/computer.h"

#include <utility>

namespace rubicon::motes_simulator {

namespace {

/// Between two packets; longer than any acknowledgement takes (wsn.md 9.7).
constexpr auto kPause = std::chrono::milliseconds(200);

}  // namespace

Computer::Computer(ComputerOptions options, SinkFirmware& sink, Scheduler& scheduler)
    : options_(options), sink_(sink), scheduler_(scheduler) {
  sink_.connect([this](ByteView bytes) { received(bytes); });
  send(motes::packet_of(motes::AmType::kConfig, motes::encode_config({motes::kSetIslandId, options_.island})));
}

Computer::~Computer() {
  sink_.connect({});
}

void Computer::received(ByteView bytes) {
  while (const auto frame = reader_.next(bytes)) {
    if (frame->protocol == motes::kHdlcPacket) on_packet(frame->packet);
  }
}

void Computer::on_packet(ByteView bytes) {
  const auto packet = motes::decode_packet(bytes);
  if (!packet || !packet->is(motes::AmType::kNetMessage)) return;
  const auto message = motes::decode_net(packet->payload);
  const auto record = message ? motes::decode_record(*message) : Result<motes::Record>(motes::OtherRecord{});
  const auto* joined = record ? std::get_if<motes::Joined>(&*record) : nullptr;
  if (joined == nullptr) return;
  const auto wanted = options_.updates
                          ? motes::encode_record(motes::ReadUpdates{options_.period, joined->transducers})
                          : motes::encode_record(motes::PeriodicCommand{joined->transducers, options_.period});
  const auto application = options_.updates ? motes::kApplicationControl : motes::kApplicationMockup;
  motes::NetMessage command{options_.island,
                            joined->mote,
                            options_.island,
                            motes::kBaseMote,
                            1,
                            ++sequence_,
                            0,
                            motes::kTransportConnectionless,
                            application,
                            wanted};
  send(motes::packet_of(command));
}

void Computer::send(Bytes packet) {
  if (queue_.size() < kMaxQueued) queue_.push_back(std::move(packet));
  if (!pause_.pending()) next();
}

void Computer::next() {
  if (queue_.empty()) return;
  sink_.received(motes::hdlc_acked_packet(++serial_sequence_, queue_.front()));
  queue_.pop_front();
  pause_ = scheduler_.after(kPause, [this] { next(); });
}

}  // namespace rubicon::motes_simulator
