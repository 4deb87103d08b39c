#include "networks/wsn/packet_monitor.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/bytes.h"
#include "model/json_members.h"
#include "model/message_fields.h"
#include "motes/mote_packet.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

using nlohmann::json;

/// Longest id of a request that a reply repeats.
constexpr std::size_t kMaxIdNumber = 200;

}  // namespace

Result<void> PacketMonitor::receive(const model::Message& message) {
  const auto& opaque = std::get<model::Opaque>(message.body);
  // A member that may send to one mote must not see the others.
  if (!message.destination.device.empty())
    return fail(ErrorCode::kRefused, "a wsn.request concerns the whole network: address that, not a mote");
  const auto object = model::read_tool_request(opaque);
  if (!object) return fail(object.error());
  const auto& request = *object;
  const auto id = model::text_of(request, "id").substr(0, kMaxIdNumber);
  const auto what = model::text_of(request, "do");
  json answer{{"id", id}, {"ok", true}, {"line", up_()}};
  Result<void> done = fail(ErrorCode::kInvalid, fmt::format("do is {}, expected monitor", model::quoted(what)));
  if (what == "monitor") done = monitors_.ask(message.source, id, request);
  if (!done) answer = {{"id", id}, {"ok", false}, {"why", done.error().text}};
  network::send_text(host_, message.source, kReplyTag, model::dump(answer));
  return {};
}

void PacketMonitor::show(ByteView packet, bool outgoing) {
  if (!monitors_.any()) return;
  const auto about = motes::describe_packet(packet);
  json out{{"time", base::to_seconds(host_.scheduler().wall_now())},
           {"direction", outgoing ? "out" : "in"},
           {"kind", about.kind},
           {"hex", base::to_hex(packet)},
           {"text", about.text}};
  if (const auto mote = outgoing ? about.destination : about.source) out["mote"] = *mote;
  monitors_.send(kPacketTag, model::dump(out));
}

}  // namespace rubicon::networks::wsn
