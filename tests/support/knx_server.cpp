#include "support/knx_server.h"

#include <gtest/gtest.h>

namespace rubicon::support {

namespace {

constexpr std::uint16_t kAnswerer = 0x11fa;

std::uint8_t high(std::uint16_t value) {
  return static_cast<std::uint8_t>(value >> 8);
}
std::uint8_t low(std::uint16_t value) {
  return static_cast<std::uint8_t>(value & 0xff);
}

/// L_Data.ind, written from the specification: shares no mistake with the codec under test.
Bytes indication(std::uint16_t source, std::uint16_t group, const Bytes& tpdu) {
  const auto length = static_cast<std::uint8_t>(tpdu.size() - 1);
  const std::uint8_t control = length > 15 ? 0x3c : 0xbc;
  Bytes frame{0x29, 0, control, 0xe0, high(source), low(source), high(group), low(group), length};
  frame.insert(frame.end(), tpdu.begin(), tpdu.end());
  return frame;
}

knx_simulator::ServerOptions server_options(const KnxServer::Options& options) {
  knx_simulator::ServerOptions out;
  out.at = options.at;
  out.tunnels = options.tunnels;
  out.first_address = options.first_address;
  out.wanted_addresses = options.wanted_addresses;
  out.data_port = options.data_port;
  out.secure = options.secure;
  return out;
}

transport::Transports& joined(transport::MemoryTransports& host, transport::MemoryNet& net, const std::string& at) {
  host.join(net, at);
  return host;
}

}  // namespace

KnxServer::KnxServer(Scheduler& scheduler, transport::MemoryNet& net, const Options& options)
    : Server(scheduler, joined(host, net, options.at.address), server_options(options)), scheduler_(scheduler) {
  on_frame = [this](const Heard& frame) { record(frame); };
  start();
}

void KnxServer::start() {
  const auto started = Server::start();
  EXPECT_TRUE(started) << started.error().text;
}

void KnxServer::record(const Heard& frame) {
  heard_.push_back(frame);
  const Heard copy = frame;
  if (copy.tpdu.size() == 2 && (copy.tpdu[1] & 0xc0) == 0) answer(copy.destination);
  if (on_heard) on_heard(copy);
}

void KnxServer::answer(std::uint16_t group) {
  if (!answers.contains(group)) return;
  answering_.push_back(scheduler_.after(answer_time, [this, group] {
    const auto found = answers.find(group);
    if (found != answers.end()) inject(kAnswerer, group, 0x40, found->second.value, found->second.small);
  }));
}

void KnxServer::inject(std::uint16_t source, std::uint16_t group, std::uint8_t apci, const Bytes& value, bool small) {
  Bytes tpdu{0, apci};
  if (small) tpdu[1] = static_cast<std::uint8_t>(apci | value.at(0));
  if (!small) tpdu.insert(tpdu.end(), value.begin(), value.end());
  inject_cemi(indication(source, group, tpdu));
}

void KnxServer::inject_read(std::uint16_t source, std::uint16_t group) {
  inject_cemi(indication(source, group, {0, 0}));
}

}  // namespace rubicon::support
