#include <cstdlib>

#include "fuzz_target.h"
#include "networks/knx/line/tunnel_sockets.h"
#include "networks/knx/wire/cemi.h"
#include "networks/knx/wire/message.h"

namespace rubicon::fuzz::knx_frame_fuzz {

namespace {

using namespace rubicon::networks::knx::line;
using namespace rubicon::networks::knx::wire;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A telegram that was understood is understood again.
void check_cemi(ByteView cemi) {
  require(!describe(cemi).empty());
  (void)confirms(cemi, cemi);
  (void)control1_of(cemi);
  const auto frame = read_data_frame(cemi);
  if (!frame) return;
  const auto copy = write(*frame);
  const auto again = read_data_frame(copy);
  require(again && again->destination == frame->destination && again->tpdu.size() == frame->tpdu.size());
  const auto telegram = to_telegram(*frame);
  if (!telegram) return;
  const auto written = write_telegram(frame->code, *telegram);
  require(written.has_value());
  const auto read = read_telegram(*written);
  require(read && *read == *telegram);
}

void check_dibs(const std::vector<Dib>& dibs) {
  const auto description = read_description(dibs);
  require(read_description(to_dibs(description)) == description);
}

/// A frame that was read is written as something that reads the same.
void check_frame(ByteView bytes) {
  const auto message = read_message(bytes);
  if (!message) {
    require(!message.error().text.empty());
    return;
  }
  const auto written = write(*message);
  require(written.size() <= bytes.size());
  const auto again = read_message(written);
  require(again && again->index() == message->index() && write(*again) == written);
  if (const auto* request = std::get_if<ConnectionRequest>(&*message)) check_cemi(request->cemi);
  if (const auto* routing = std::get_if<RoutingIndication>(&*message)) check_cemi(routing->cemi);
  if (const auto* search = std::get_if<SearchResponse>(&*message)) check_dibs(search->dibs);
  if (const auto* description = std::get_if<DescriptionResponse>(&*message)) check_dibs(description->dibs);
}

}  // namespace

/// Input: bytes of a stream; the first frame also as a datagram, and all as cEMI.
FUZZ_TARGET(knx_frame) {
  const ByteView bytes(data, size);
  check_frame(bytes);
  check_cemi(bytes);
  FrameStream stream;
  for (std::size_t at = 0; at < size; at += 7) {
    stream.append(bytes.subspan(at, std::min<std::size_t>(7, size - at)));
    for (;;) {
      const auto frame = stream.next();
      if (!frame) return 0;
      if (frame->empty()) break;
      require(frame->size() >= kHeaderSize);
      check_frame(*frame);
    }
  }
  return 0;
}

}  // namespace rubicon::fuzz::knx_frame_fuzz
