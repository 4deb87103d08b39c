#include "transport/mosquitto_client.h"

#include <fcntl.h>
#include <mqtt_protocol.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace rubicon::transport {

namespace {

using std::chrono::seconds;

Properties property_of(int id, std::uint32_t value) {
  mosquitto_property* made = nullptr;
  ::mosquitto_property_add_int32(&made, id, value);
  return Properties(made);
}

/// Of correlation data (MQTT 5, section 1.5.6: binary data has a length of two bytes).
constexpr std::size_t kMaxCorrelation = 65535;

Properties expiry_property(const MqttPublication& publication) {
  if (publication.expiry <= Duration::zero()) return nullptr;
  constexpr seconds::rep kMaxTime = std::numeric_limits<std::uint32_t>::max();
  const auto expiry = std::min(std::chrono::ceil<seconds>(publication.expiry).count(), kMaxTime);
  return property_of(MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, static_cast<std::uint32_t>(expiry));
}

/// What the library allocated, which is freed.
std::string taken_over(void* data, std::size_t length) {
  std::string text;
  if (data != nullptr) text.assign(static_cast<const char*>(data), length);
  std::free(data);
  return text;
}
std::string taken_over(char* text) {
  return taken_over(text, text == nullptr ? 0 : std::strlen(text));
}

/// The user property of this name; empty = none.
std::string read_sender(const mosquitto_property* properties) {
  const auto* at = properties;
  for (bool again = false; at != nullptr; again = true) {
    char *name = nullptr, *value = nullptr;
    at = ::mosquitto_property_read_string_pair(at, MQTT_PROP_USER_PROPERTY, &name, &value, again);
    const auto is = taken_over(name);
    auto text = taken_over(value);
    if (at != nullptr && is == "sender") return text;
  }
  return {};
}

}  // namespace

MqttConnack read_connack(const mosquitto_property* properties, bool version_5, Duration our_keep_alive) {
  auto keep_alive = static_cast<std::uint16_t>(std::chrono::floor<seconds>(our_keep_alive).count());
  std::uint32_t largest = 0;
  std::uint8_t retains = 1;
  ::mosquitto_property_read_int32(properties, MQTT_PROP_MAXIMUM_PACKET_SIZE, &largest, false);
  ::mosquitto_property_read_byte(properties, MQTT_PROP_RETAIN_AVAILABLE, &retains, false);
  ::mosquitto_property_read_int16(properties, MQTT_PROP_SERVER_KEEP_ALIVE, &keep_alive, false);
  return {version_5 ? MqttVersion::k5 : MqttVersion::k311, largest, retains != 0, seconds(keep_alive), {}};
}

std::size_t read_receive_maximum(const mosquitto_property* properties) {
  std::uint16_t at_once = std::numeric_limits<std::uint16_t>::max();
  ::mosquitto_property_read_int16(properties, MQTT_PROP_RECEIVE_MAXIMUM, &at_once, false);
  return at_once;
}

Properties connect_properties(const MqttOptions& options) {
  return property_of(MQTT_PROP_MAXIMUM_PACKET_SIZE, static_cast<std::uint32_t>(options.largest_packet));
}

Properties publish_properties(const MqttPublication& publication) {
  auto properties = expiry_property(publication);
  auto* all = properties.release();
  if (!publication.response_topic.empty())
    ::mosquitto_property_add_string(&all, MQTT_PROP_RESPONSE_TOPIC, publication.response_topic.c_str());
  if (const auto& data = publication.correlation; !data.empty() && data.size() <= kMaxCorrelation)
    ::mosquitto_property_add_binary(&all, MQTT_PROP_CORRELATION_DATA, data.data(),
                                    static_cast<std::uint16_t>(data.size()));
  return Properties(all);
}

std::unique_ptr<MqttAbout> read_about(const mosquitto_property* properties) {
  if (properties == nullptr) return nullptr;
  auto about = std::make_unique<MqttAbout>();
  std::uint32_t expiry = 0;
  ::mosquitto_property_read_int32(properties, MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, &expiry, false);
  about->expiry = seconds(expiry);
  char* text = nullptr;
  ::mosquitto_property_read_string(properties, MQTT_PROP_RESPONSE_TOPIC, &text, false);
  about->response_topic = taken_over(text);
  void* data = nullptr;
  std::uint16_t length = 0;
  ::mosquitto_property_read_binary(properties, MQTT_PROP_CORRELATION_DATA, &data, &length, false);
  about->correlation = taken_over(data, length);
  about->sender = read_sender(properties);
  return about;
}

KeptSocket::KeptSocket(int socket) : descriptor_(::fcntl(socket, F_DUPFD_CLOEXEC, 0)) {}

KeptSocket::~KeptSocket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void KeptSocket::await_end(std::chrono::steady_clock::time_point latest) const {
  if (descriptor_ < 0) return;
  ::shutdown(descriptor_, SHUT_WR);
  std::array<char, 65536> bytes;
  for (auto left = latest - std::chrono::steady_clock::now(); left > std::chrono::steady_clock::duration::zero();
       left = latest - std::chrono::steady_clock::now()) {
    pollfd ready{descriptor_, POLLIN, 0};
    const auto patience = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    if (::poll(&ready, 1, static_cast<int>(patience)) <= 0) continue;
    const auto count = ::recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count == 0 || (count < 0 && errno != EAGAIN && errno != EINTR)) return;
  }
}

void acknowledge_now(int socket) {
  const int yes = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_QUICKACK, &yes, sizeof yes);
}

bool is_ended(int socket) {
  char byte = 0;
  return ::recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

}  // namespace rubicon::transport
