#include "networks/knx/capture.h"

#include <algorithm>

namespace rubicon::networks::knx {

namespace {

/// Memory that a stored frame takes besides its bytes.
constexpr std::size_t kFrameOverhead = 64;
constexpr std::uint16_t kPort = 3671;
constexpr std::size_t kIpHeader = 20, kUdpHeader = 8, kKnxHeader = 6;

void put16(Bytes& out, std::size_t value) {
  out.push_back(static_cast<std::uint8_t>(value >> 8));
  out.push_back(static_cast<std::uint8_t>(value));
}

/// The numbers of pcap headers are little endian here.
void put32_little(Bytes& out, std::uint64_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_ip_header(Bytes& out, std::size_t length, bool outgoing) {
  const auto start = out.size();
  const std::uint8_t fixed[] = {0x45, 0, 0, 0, 0, 0, 0, 0, 16, 17, 0, 0, 127, 0, 0, 1, 224, 0, 23, 12};
  out.insert(out.end(), std::begin(fixed), std::end(fixed));
  out[start + 2] = static_cast<std::uint8_t>(length >> 8);
  out[start + 3] = static_cast<std::uint8_t>(length);
  if (!outgoing) out[start + 15] = 2;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < kIpHeader; i += 2)
    sum += static_cast<std::uint32_t>(out[start + i] << 8 | out[start + i + 1]);
  sum = (sum >> 16) + (sum & 0xffff);
  sum += sum >> 16;
  out[start + 10] = static_cast<std::uint8_t>(~sum >> 8);
  out[start + 11] = static_cast<std::uint8_t>(~sum);
}

}  // namespace

void Capture::add(ByteView cemi, bool outgoing, WallTime now) {
  frames_.push_back({++last_, now, outgoing, Bytes(cemi.begin(), cemi.end())});
  bytes_ += cemi.size() + kFrameOverhead;
  while (!frames_.empty() && (bytes_ > limits_.bytes || frames_.front().time + limits_.age < now)) {
    bytes_ -= frames_.front().cemi.size() + kFrameOverhead;
    frames_.pop_front();
  }
}

Bytes pcap_file_header() {
  Bytes out{0xd4, 0xc3, 0xb2, 0xa1, 2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  put32_little(out, 65535);
  put32_little(out, 101);
  return out;
}

Bytes pcap_record(const Capture::Frame& frame) {
  const auto length = kIpHeader + kUdpHeader + kKnxHeader + frame.cemi.size();
  const auto microseconds =
      std::chrono::duration_cast<std::chrono::microseconds>(frame.time.time_since_epoch()).count();
  Bytes out;
  put32_little(out, static_cast<std::uint64_t>(microseconds / 1'000'000));
  put32_little(out, static_cast<std::uint64_t>(microseconds % 1'000'000));
  put32_little(out, length);
  put32_little(out, length);
  put_ip_header(out, length, frame.outgoing);
  put16(out, kPort);
  put16(out, kPort);
  put16(out, length - kIpHeader);
  put16(out, 0);       // no checksum
  put16(out, 0x0610);  // header size 6, version 1.0
  put16(out, 0x0530);  // ROUTING_INDICATION
  put16(out, kKnxHeader + frame.cemi.size());
  out.insert(out.end(), frame.cemi.begin(), frame.cemi.end());
  return out;
}

namespace {

constexpr Duration kRepetitionTime = std::chrono::milliseconds(200);
constexpr std::size_t kMaxRecent = 16;

bool same(const wire::Telegram& one, const wire::Telegram& other) {
  return one.service == other.service && one.destination == other.destination && one.source == other.source &&
         one.payload == other.payload;
}

}  // namespace

bool Repetitions::contain(const wire::Telegram& telegram, SteadyTime now) {
  while (!recent_.empty() && (recent_.size() > kMaxRecent || recent_.front().first + kRepetitionTime < now))
    recent_.pop_front();
  const auto is_same = [&](const auto& one) { return same(one.second, telegram); };
  if (telegram.repeated && std::any_of(recent_.begin(), recent_.end(), is_same)) {
    ++count_;
    return true;
  }
  recent_.emplace_back(now, telegram);
  return false;
}

}  // namespace rubicon::networks::knx
