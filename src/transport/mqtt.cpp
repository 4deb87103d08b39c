#include "transport/mqtt.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "model/findings.h"
#include "transport/sockets.h"

namespace rubicon::transport {

namespace {

constexpr std::size_t kMaxTextLength = 65535;
constexpr std::ptrdiff_t kMaxLevels = 200;

/// Brokers and clients may refuse the others (MQTT 5, section 1.5.4), and libmosquitto does.
bool is_mqtt_character(char32_t code) {
  const bool control = code < 0x20 || (code >= 0x7f && code <= 0x9f);
  const bool noncharacter = (code >= 0xfdd0 && code <= 0xfdef) || (code & 0xfffe) == 0xfffe;
  return !control && !noncharacter;
}

bool is_plain_character(unsigned char c) {
  return c >= 0x20 && c < 0x7f;
}

bool has_few_levels(std::string_view topic) {
  return std::count(topic.begin(), topic.end(), '/') < kMaxLevels;
}

/// Takes the first level and its `/` away; `more` = a level follows, which may be empty.
std::string_view take_level(std::string_view& text, bool& more) {
  const auto end = text.find('/');
  const auto level = text.substr(0, end);
  more = end != text.npos;
  text.remove_prefix(more ? end + 1 : text.size());
  return level;
}

}  // namespace

bool is_mqtt_text(std::string_view text) {
  if (text.empty() || text.size() > kMaxTextLength) return false;
  text.remove_prefix(
      static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_plain_character) - text.begin()));
  while (!text.empty()) {
    const auto character = base::take_utf8(text);
    if (!character || !is_mqtt_character(*character)) return false;
  }
  return true;
}

bool is_mqtt_topic(std::string_view topic) {
  return is_mqtt_text(topic) && has_few_levels(topic) && topic.find('+') == topic.npos && topic.find('#') == topic.npos;
}

bool is_mqtt_filter(std::string_view filter) {
  if (!is_mqtt_text(filter) || !has_few_levels(filter)) return false;
  for (bool more = true; more;) {
    const auto level = take_level(filter, more);
    if (level == "#" && more) return false;
    if (level.size() > 1 && level.find_first_of("+#") != level.npos) return false;
  }
  return true;
}

bool mqtt_matches(std::string_view filter, std::string_view topic) {
  if (topic.starts_with('$') && !filter.starts_with('$')) return false;
  for (bool more_filter = true, more_topic = true;;) {
    const auto wanted = take_level(filter, more_filter);
    if (wanted == "#") return true;
    const auto level = take_level(topic, more_topic);
    if (wanted != "+" && wanted != level) return false;
    if (!more_topic) return !more_filter || filter == "#";  // `a/#` matches `a` too
    if (!more_filter) return false;
  }
}

namespace {

using std::chrono::seconds;

/// MQTT 3.1.1, section 3.1.3.1: what each server must accept.
bool is_client_id(std::string_view id) {
  return id.size() <= 23 && std::all_of(id.begin(), id.end(), [](unsigned char c) {
           return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
         });
}

const char* fault_of(const MqttOptions& options) {
  if (options.host.empty() || options.port == 0) return "no host or port to connect to";
  if (!is_client_id(options.client_id)) return "the client id must have at most 23 letters and digits";
  if (!options.user.empty() && !is_mqtt_text(options.user)) return "the user has characters that MQTT does not allow";
  if (!options.password.empty() && options.user.empty()) return "a password needs a user";
  if (options.keep_alive < seconds(5) || options.keep_alive > seconds(65535))
    return "keep-alive must be 5 s to 65535 s";
  if (options.largest_packet < 1024 || options.largest_packet > 268'435'460)
    return "the largest packet must have 1 KiB to 256 MiB";
  if (options.will && !is_mqtt_topic(options.will->topic)) return "the will has no topic";
  if (options.will && options.will->qos > 1) return "the QoS of the will must be 0 or 1";
  if (options.tls && options.tls->certificate_file.empty() != options.tls->key_file.empty())
    return "a client certificate needs its key";
  return nullptr;
}

std::string short_text(std::string_view topic) {
  return base::one_line(topic.substr(0, 100));
}

struct Reason {
  int code;
  ErrorCode means;
  const char* text;
  std::string_view finding{};
};

/// MQTT 5, section 2.4; those that a client of our subset may meet.
constexpr Reason kReasons[] = {
    {0x81, ErrorCode::kInvalid, "says that a packet was malformed"},
    {0x82, ErrorCode::kInvalid, "says that we broke the protocol"},
    {0x84, ErrorCode::kRefused, "does not speak this version of MQTT"},
    {0x85, ErrorCode::kRefused, "refuses the client id"},
    {0x86, ErrorCode::kRefused, "refuses the user or the password", model::findings::kLoginRefused},
    {0x87, ErrorCode::kRefused, "refuses the connection: not authorised (user, password or access list)",
     model::findings::kLoginRefused},
    {0x88, ErrorCode::kUnreachable, "is not available"},
    {0x89, ErrorCode::kUnreachable, "is busy"},
    {0x8a, ErrorCode::kRefused, "has banned this client"},
    {0x8b, ErrorCode::kUnreachable, "is shutting down"},
    {0x8c, ErrorCode::kRefused, "wants another method of authentication"},
    {0x8d, ErrorCode::kUnreachable, "did not hear us for too long"},
    {0x8e, ErrorCode::kDuplicate, "gave the session to another client with the same client id"},
    {0x93, ErrorCode::kBusy, "got more messages at a time than it takes"},
    {0x95, ErrorCode::kOutOfRange, "got a packet that is too large for it"},
    {0x97, ErrorCode::kBusy, "says that a quota is exceeded"},
    {0x9a, ErrorCode::kUnsupported, "keeps no retained messages, as our will is one"},
    {0x98, ErrorCode::kUnreachable, "closes the connection by administrative action"},
    {0x9c, ErrorCode::kRefused, "wants us to use another server"},
    {0x9d, ErrorCode::kRefused, "has moved to another server"},
};

/// MQTT 5, table 3-4: those of 0x80 and above.
constexpr Reason kPublicationReasons[] = {
    {0x80, ErrorCode::kUnreachable, "unspecified error"},
    {0x83, ErrorCode::kUnreachable, "a reason of its own"},
    {0x87, ErrorCode::kRefused, "not authorised (its access list)"},
    {0x90, ErrorCode::kInvalid, "it does not accept the topic"},
    {0x91, ErrorCode::kUnreachable, "packet identifier in use"},
    {0x95, ErrorCode::kOutOfRange, "larger than it takes"},
    {0x97, ErrorCode::kBusy, "quota exceeded"},
    {0x99, ErrorCode::kInvalid, "the payload is not in the format that was announced"},
};

}  // namespace

std::string mqtt_name(const MqttOptions& options) {
  return "MQTT " + to_string(Endpoint{options.host, options.port});
}

Result<void> check_options(const MqttOptions& options) {
  if (const auto* fault = fault_of(options))
    return fail(ErrorCode::kInvalid, fmt::format("{}: {}", mqtt_name(options), fault));
  return {};
}

Result<void> check_filter(std::string_view filter, std::uint8_t qos, const std::string& line) {
  if (!is_mqtt_filter(filter))
    return fail(ErrorCode::kInvalid, fmt::format("{}: no filter to subscribe to: {}", line, short_text(filter)));
  if (qos > 1) return fail(ErrorCode::kInvalid, fmt::format("{}: QoS {}, expected 0 or 1", line, qos));
  return {};
}

Result<void> check_publication(const MqttPublication& publication, std::size_t largest, const std::string& line) {
  if (!is_mqtt_topic(publication.topic))
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: cannot publish to {}: it is not a topic", line, short_text(publication.topic)));
  if (publication.qos > 1)
    return fail(ErrorCode::kInvalid, fmt::format("{}: QoS {}, expected 0 or 1", line, publication.qos));
  constexpr std::size_t kExpiry = 5;
  const auto size =
      packet_size(publication.topic, publication.payload) + (publication.expiry > Duration::zero() ? kExpiry : 0);
  if (size > largest)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{}: cannot publish {} bytes: the broker takes packets of {} bytes", line, size, largest));
  return {};
}

/// The properties of version 5 are empty; their length takes one byte.
std::size_t packet_size(std::string_view topic, std::string_view payload) {
  constexpr std::size_t kTopicLength = 2, kPacketId = 2, kProperties = 1;
  const auto rest = kTopicLength + topic.size() + kPacketId + kProperties + payload.size();
  const std::size_t digits = rest < 128 ? 1 : rest < 16384 ? 2 : rest < 2097152 ? 3 : 4;
  return 1 + digits + rest;
}

Error mqtt_error(int reason, const std::string& line) {
  const auto* const found =
      std::find_if(std::begin(kReasons), std::end(kReasons), [&](const auto& known) { return known.code == reason; });
  if (found == std::end(kReasons))
    return {ErrorCode::kUnreachable, fmt::format("{}: the broker closed the connection, reason {:#04x}", line, reason)};
  return {found->means, fmt::format("{}: the broker {}", line, found->text), found->finding};
}

Error publication_error(int reason, const std::string& line, std::string_view topic) {
  const auto* const found = std::find_if(std::begin(kPublicationReasons), std::end(kPublicationReasons),
                                         [&](const auto& known) { return known.code == reason; });
  const bool known = found != std::end(kPublicationReasons);
  return {known ? found->means : ErrorCode::kUnreachable,
          fmt::format("{}: the broker did not take the message to {}: {} (reason {:#04x})", line, short_text(topic),
                      known ? found->text : "unknown reason", reason)};
}

int reason_of_return_code(int code) {
  constexpr int kReasonOf[] = {0x00, 0x84, 0x85, 0x88, 0x86, 0x87};
  return code >= 0 && code <= 5 ? kReasonOf[code] : 0x80;
}

}  // namespace rubicon::transport
