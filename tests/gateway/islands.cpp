#include "gateway/islands.h"

namespace rubicon::gateway {

namespace {

PlayedNetwork* last_made = nullptr;

constexpr network::NetworkType kPlayed{
    .name = "played",
    .summary = "",
    .sample_config = "",
    .make = [](const network::NetworkConfig&, network::NetworkHost& host) -> Result<std::unique_ptr<network::Network>> {
      auto made = std::make_unique<PlayedNetwork>(host);
      last_made = made.get();
      return made;
    }};

}  // namespace

void PlayedNetwork::say_to(const std::string& device, Address to, model::Body body) {
  Message message;
  message.source.device = device;
  message.destination = std::move(to);
  message.body = std::move(body);
  host.deliver(std::move(message));
}

Island::Island(std::uint32_t number, VirtualScheduler& time, tuples::MemoryEcology& ecology, base::LogSink& log,
               GatewayLimits limits)
    : link(*ecology.join(OwnerId{number})),
      space(OwnerId{number}, time, *link),
      gateway(time, space, log, limits),
      networks(OwnerId{number}, time, files, log, gateway) {
  gateway.connect(networks);
  for (const std::string id : {"a", "b"}) {
    ConfigErrors errors;
    const ConfigNode nothing;
    ConfigReader options(nothing, id, errors);
    EXPECT_TRUE(networks.add(kPlayed, {id, OwnerId{number}, options, types, {}}));
    played[id] = last_made;
  }
  networks.start();
}

std::vector<Message> Island::heard_of(MessageKind kind) const {
  std::vector<Message> found;
  for (const auto& message : heard) {
    if (message.kind() == kind) found.push_back(message);
  }
  return found;
}

std::vector<Acknowledge> Island::answers() const {
  std::vector<Acknowledge> found;
  for (const auto& message : heard) {
    if (const auto* answer = std::get_if<Acknowledge>(&message.body)) found.push_back(*answer);
  }
  return found;
}

void Island::listen(MessageKind kind) {
  handles.push_back(gateway.subscribe(kind, [this](const Message& message) { heard.push_back(message); }));
}

void Island::send(Address to, model::Body body) {
  Message message;
  message.source = address();
  message.destination = std::move(to);
  message.body = std::move(body);
  gateway.send(std::move(message));
}

std::string text_of(const Message& message) {
  const auto* opaque = std::get_if<Opaque>(&message.body);
  return opaque == nullptr ? std::string() : std::string(base::as_text(opaque->bytes));
}

std::vector<std::string> texts_of(const std::vector<Message>& messages) {
  std::vector<std::string> texts;
  for (const auto& message : messages) texts.push_back(text_of(message));
  return texts;
}

model::Updates reading(std::int64_t value, std::size_t count) {
  model::Updates updates;
  for (std::size_t i = 0; i < count; ++i) updates.readings.push_back({kMeter, value, {}});
  return updates;
}

}  // namespace rubicon::gateway
