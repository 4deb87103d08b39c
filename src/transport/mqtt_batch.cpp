#include "transport/mqtt_batch.h"

#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <limits>
#include <string_view>

#include "transport/mqtt_tls.h"

namespace rubicon::transport {

namespace {

/// MQTT 5, sections 2.2.2.2 and 3.3.
constexpr unsigned char kPublish = 0x30, kRetain = 0x01, kExpiry = 0x02, kResponseTopic = 0x08, kCorrelation = 0x09;
constexpr std::size_t kMaxBinary = 65535;

void add_number(std::string& bytes, std::uint32_t number, int length) {
  while (length-- > 0) bytes += static_cast<char>(number >> (8U * static_cast<unsigned>(length)));
}

/// A length of two bytes, then the text (section 1.5.4).
void add_text(std::string& bytes, std::string_view text) {
  add_number(bytes, static_cast<std::uint32_t>(text.size()), 2);
  bytes += text;
}

/// Variable Byte Integer (section 1.5.5).
void add_length(std::string& bytes, std::size_t length) {
  for (; length >= 0x80; length >>= 7U) bytes += static_cast<char>(length | 0x80U);
  bytes += static_cast<char>(length);
}
std::size_t length_size(std::size_t length) {
  return length < 0x80 ? 1 : length < 0x4000 ? 2 : length < 0x200000 ? 3 : 4;
}

/// Those that a PUBLISH of ours may have.
struct PublishProperties {
  explicit PublishProperties(const MqttPublication& publication) {
    using std::chrono::seconds;
    constexpr seconds::rep kMaxExpiry = std::numeric_limits<std::uint32_t>::max();
    if (publication.expiry > Duration::zero())
      expiry = static_cast<std::uint32_t>(std::min(std::chrono::ceil<seconds>(publication.expiry).count(), kMaxExpiry));
    if (is_mqtt_text(publication.response_topic)) response_topic = publication.response_topic;
    if (publication.correlation.size() <= kMaxBinary) correlation = publication.correlation;
    size = (expiry > 0 ? 5 : 0) + (response_topic.empty() ? 0 : 3 + response_topic.size()) +
           (correlation.empty() ? 0 : 3 + correlation.size());
  }

  void add_to(std::string& bytes) const {
    add_length(bytes, size);
    if (expiry > 0) {
      bytes += static_cast<char>(kExpiry);
      add_number(bytes, expiry, 4);
    }
    if (!response_topic.empty()) {
      bytes += static_cast<char>(kResponseTopic);
      add_text(bytes, response_topic);
    }
    if (!correlation.empty()) {
      bytes += static_cast<char>(kCorrelation);
      add_text(bytes, correlation);
    }
  }

  std::uint32_t expiry = 0;  ///< in s; 0 = none
  std::string_view response_topic{}, correlation{};
  std::size_t size = 0;  ///< in bytes
};

}  // namespace

bool MqttBatch::add(const MqttPublication& publication, const Limits& limits) {
  const PublishProperties properties(publication);
  const auto of_properties = limits.version_5 ? length_size(properties.size) + properties.size : 0;
  const auto rest = 2 + publication.topic.size() + of_properties + publication.payload.size();
  if (limits.largest_packet > 0 && 1 + length_size(rest) + rest > limits.largest_packet) return false;
  bytes_ += static_cast<char>(kPublish | (publication.retain && limits.retains ? kRetain : 0));
  add_length(bytes_, rest);
  add_text(bytes_, publication.topic);
  if (limits.version_5) properties.add_to(bytes_);
  bytes_ += publication.payload;
  return true;
}

bool MqttBatch::write(int socket, void* ssl) {
  while (written_ < bytes_.size()) {
    const auto rest = std::string_view(bytes_).substr(written_);
    const auto count =
        ssl == nullptr ? ::send(socket, rest.data(), rest.size(), MSG_DONTWAIT | MSG_NOSIGNAL) : tls_write(ssl, rest);
    if (count < 0) return errno == EAGAIN || errno == EINTR;
    written_ += static_cast<std::size_t>(count);
  }
  bytes_.clear();
  if (bytes_.capacity() > 4 * kEnough) bytes_.shrink_to_fit();
  written_ = 0;
  return true;
}

}  // namespace rubicon::transport
