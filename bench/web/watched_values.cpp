#include "web/watched_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "web/generated_points.h"

namespace rubicon::bench::web {

namespace {

using namespace std::chrono_literals;

constexpr auto kSnapshotTime = 60s;
constexpr auto kQuiet = 500ms;

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double age_ms(double written) {
  return (wall_seconds() - written) * 1000;
}

/// The point of a key or topic, without its last part.
std::size_t point_of(std::string text, std::size_t points) {
  static std::map<std::string, std::size_t> known;
  std::replace(text.begin(), text.end(), '/', '.');
  for (auto point = known.size(); point < points; ++point) known[point_key(point)] = point;
  return known.at(text);
}

}  // namespace

void Seen::restart() {
  updates = messages = bytes = 0;
  ages_ms.clear();
}

std::size_t Seen::wrong(std::uint64_t made, std::uint64_t before) const {
  std::size_t count = 0;
  for (std::size_t point = 0; point < values.size(); ++point) {
    const auto last = last_update(point, values.size(), made);
    count += last > before && values[point] != value_of(last) ? 1U : 0U;
  }
  return count;
}

void ValuesClient::watch(Clock::duration span) {
  const auto until = Clock::now() + span;
  while (take(until)) continue;
}

void ValuesClient::settle() {
  while (take(Clock::now() + kQuiet)) continue;
}

PageClient::PageClient(int port, int devices) : client_(port, "/api/v1/ws") {
  seen.values.resize(static_cast<std::size_t>(devices) * kPointsPerDevice);
  client_.send_text(fmt::format(R"({{"id":1,"do":"subscribe","pattern":"{}"}})", kValues));
  for (const auto until = Clock::now() + kSnapshotTime; !complete_;) {
    if (!PageClient::take(until)) throw std::runtime_error("no snapshot");
  }
  if (points_.size() != seen.values.size()) throw std::runtime_error("the snapshot lacks points");
}

bool PageClient::take(Clock::time_point until) {
  const auto text = client_.next(until);
  if (!text) return false;
  const auto frame = nlohmann::json::parse(*text);
  ++seen.messages;
  seen.bytes += text->size();
  const auto keys = frame.value("k", nlohmann::json::object());
  for (const auto& [number, key] : keys.items()) {
    const auto index = base::parse_number<std::size_t>(number).value_or(0);
    if (points_.size() <= index) points_.resize(index + 1);
    const auto name = key.get<std::string>();
    const auto begin = name.find(':') + 1;
    points_[index] = point_of(name.substr(begin, name.rfind('.') - begin), seen.values.size());
  }
  double newest = 0;
  for (const auto& set : frame.value("set", nlohmann::json::array())) {
    seen.values[points_.at(set[0].get<std::size_t>())] = set[1].get<std::string>();
    newest = std::max(newest, set[3].get<double>());
    ++seen.updates;
  }
  if (newest != 0) seen.ages_ms.push_back(age_ms(newest));
  complete_ = complete_ || frame.contains("snapshot");
  return true;
}

BrokerClient::BrokerClient(int port, int devices) : client_(port, "/", "mqtt") {
  using namespace std::string_literals;
  seen.values.resize(static_cast<std::size_t>(devices) * kPointsPerDevice);
  client_.send_bytes("\x10\x11\0\x04MQTT\x04\x02\0\0\0\x05watch"s);  // CONNECT: clean session, no keep-alive
  client_.send_bytes("\x82\x06\0\x01\0\x01#\0"s);                    // SUBSCRIBE to all, QoS 0
  for (const auto until = Clock::now() + kSnapshotTime; !subscribed_;) {
    if (!BrokerClient::take(until)) throw std::runtime_error("no answer to a subscription");
  }
}

/// Packets of MQTT 3.1.1, sections 2.2 and 3.3, in a stream that the messages cut anywhere.
bool BrokerClient::take(Clock::time_point until) {
  const auto bytes = client_.next(until);
  if (!bytes) return false;
  ++seen.messages;
  seen.bytes += bytes->size();
  pending_ += *bytes;
  std::size_t at = 0;
  for (;;) {
    std::size_t length = 0, head = 1;
    bool known = false;
    for (unsigned shift = 0; at + head < pending_.size() && !known; shift += 7) {
      const auto digit = static_cast<unsigned char>(pending_[at + head++]);
      length |= static_cast<std::size_t>(digit & 0x7fU) << shift;
      known = (digit & 0x80U) == 0;
    }
    if (!known || at + head + length > pending_.size()) break;
    const auto type = static_cast<unsigned char>(pending_[at]) >> 4U;
    constexpr unsigned kPublish = 3, kSubscribed = 9;
    if (type == kPublish) publication(std::string_view(pending_).substr(at + head, length));
    subscribed_ = subscribed_ || type == kSubscribed;
    at += head + length;
  }
  pending_.erase(0, at);
  return true;
}

void BrokerClient::publication(std::string_view packet) {
  const auto size =
      static_cast<std::size_t>(static_cast<unsigned char>(packet[0])) << 8U | static_cast<unsigned char>(packet[1]);
  const auto payload = packet.substr(2 + size);
  const auto space = payload.find(' ');
  seen.values[point_of(std::string(packet.substr(2, size)), seen.values.size())] = payload.substr(0, space);
  seen.ages_ms.push_back(age_ms(std::stod(std::string(payload.substr(space + 1)))));
  ++seen.updates;
}

}  // namespace rubicon::bench::web
