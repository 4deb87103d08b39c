#include "tuples/peis/capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

namespace rubicon::tuples::peis {

namespace {

namespace fs = std::filesystem;

const std::string kFolder = RUBICON_SOURCE_DIR "/tests/cases/peis/";
constexpr std::size_t kFileHeader = 24, kEthernet = 14;
constexpr std::uint8_t kTcp = 6, kUdp = 17, kSyn = 2, kAck = 16;

struct Segment {
  std::uint32_t sequence = 0;
  ByteView bytes;
};
struct Direction {
  std::uint32_t first = 0;  ///< sequence number of the first byte
  bool of_initiator = false;
  std::vector<Segment> segments;
};

class Reader {
 public:
  void frame(ByteView frame) {
    base::ByteReader reader(frame);
    reader.skip(12);
    if (reader.u16_be() != 0x0800) return;
    const auto ip = frame.subspan(kEthernet);
    const std::size_t header = (ip[0] & 15U) * 4U;
    const auto whole = ip.first(static_cast<std::size_t>(ip[2] << 8 | ip[3]));
    if (ip[9] == kUdp) datagrams_.emplace_back(whole.begin() + static_cast<std::ptrdiff_t>(header) + 8, whole.end());
    if (ip[9] == kTcp) segment(whole.subspan(header));
  }
  Capture capture() {
    Capture capture;
    capture.datagrams = std::move(datagrams_);
    for (const auto& ports : order_)
      capture.streams.push_back({ports.first, ports.second, directions_[ports].of_initiator, joined(ports)});
    return capture;
  }

 private:
  using Ports = std::pair<std::uint16_t, std::uint16_t>;

  void segment(ByteView tcp) {
    base::ByteReader reader(tcp);
    Ports ports;
    ports.first = reader.u16_be();
    ports.second = reader.u16_be();
    const auto sequence = reader.u32_be();
    const std::uint8_t flags = tcp[13];
    if (!directions_.contains(ports)) order_.push_back(ports);
    auto& direction = directions_[ports];
    if ((flags & kSyn) != 0) {
      direction.first = sequence + 1;
      direction.of_initiator = (flags & kAck) == 0;
    }
    const auto bytes = tcp.subspan((tcp[12] >> 4) * 4U);
    if (!bytes.empty()) direction.segments.push_back({sequence, bytes});
  }

  Bytes joined(const Ports& ports) {
    auto& direction = directions_[ports];
    const auto offset = [&](const Segment& segment) { return std::size_t{segment.sequence - direction.first}; };
    std::stable_sort(direction.segments.begin(), direction.segments.end(),
                     [&](const auto& a, const auto& b) { return offset(a) < offset(b); });
    Bytes bytes;
    for (const auto& segment : direction.segments) {
      const auto at = offset(segment);
      if (at > bytes.size()) ADD_FAILURE() << "a gap at " << bytes.size() << " from port " << ports.first;
      if (at + segment.bytes.size() <= bytes.size()) continue;  // sent again
      const auto fresh = segment.bytes.subspan(bytes.size() - std::min(at, bytes.size()));
      bytes.insert(bytes.end(), fresh.begin(), fresh.end());
    }
    return bytes;
  }

  std::vector<Bytes> datagrams_;
  std::vector<Ports> order_;
  std::map<Ports, Direction> directions_;
};

}  // namespace

std::vector<std::string> capture_names() {
  std::vector<std::string> names;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(kFolder, missing)) {
    if (entry.path().extension() == ".pcap") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Capture read_capture(const std::string& name) {
  std::ifstream file(kFolder + name + ".pcap", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  base::ByteReader records(bytes);
  if (records.u32_le() != 0xa1b2c3d4) ADD_FAILURE() << name << " is no pcap file of this byte order";
  records.skip(kFileHeader - 4);
  Reader reader;
  while (records.ok() && records.remaining() > 0) {
    records.skip(8);
    const auto kept = records.u32_le(), length = records.u32_le();
    EXPECT_EQ(kept, length) << name << " has frames that were cut";
    reader.frame(records.take(kept));
  }
  EXPECT_TRUE(records.ok()) << name << " ends within a frame";
  return reader.capture();
}

}  // namespace rubicon::tuples::peis
