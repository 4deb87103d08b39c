#include "sites/engine.h"

#include <stdexcept>
#include <utility>

#include "sites/broker.h"
#include "transport/local_transports.h"

namespace rubicon::bench::sites {

namespace {

struct AtBroker {
  explicit AtBroker(transport::Loop& loop) : transports(loop) {}

  transport::LocalTransports transports;
  std::unique_ptr<tuples::mqtt::MqttEcology> ecology;
};

}  // namespace

tuples::mqtt::SpaceOptions space_options(const Meeting& meeting) {
  tuples::mqtt::SpaceOptions options;
  auto& at = options.brokers.emplace_back();
  at.line.host = "127.0.0.1";
  at.line.port = port_of(meeting);
  options.space = meeting.tag;
  options.trust_broker = true;
  if (meeting.trust.empty()) return options;
  at.user = kUser;
  at.line.tls = transport::MqttTls{meeting.trust + "ca.pem", meeting.trust + "client.pem", meeting.trust + "client.key",
                                   "broker.test"};
  return options;
}

std::shared_ptr<tuples::Ecology> open_at_broker(const Meeting& meeting, transport::Loop& loop, base::LogSink& log) {
  auto engine = std::make_shared<AtBroker>(loop);
  auto ecology = tuples::mqtt::MqttEcology::open(space_options(meeting), loop.scheduler(), engine->transports, log);
  if (!ecology) throw std::runtime_error(ecology.error().text);
  engine->ecology = std::move(*ecology);
  return {engine, engine->ecology.get()};
}

}  // namespace rubicon::bench::sites
