#include "client/message_client.h"

#include "base/bytes.h"

namespace rubicon::client {

namespace {

gateway::MessageCall opaque_call(MessageCall call) {
  return [call = std::move(call)](const Message& message) {
    const auto& opaque = std::get<model::Opaque>(message.body);
    call({message.source.island, opaque.type, std::string(base::as_text(opaque.bytes)), message.source.network,
          message.source.device});
  };
}

}  // namespace

MessageClient::MessageClient(Scheduler& scheduler, TupleSpace& space, base::LogSink& log)
    : scheduler_(scheduler), gateway_(scheduler, space, log), self_(space.self()) {
  gateway_.on_accepted([this](std::uint64_t number) { taken(number); });
  answers_ = gateway_.subscribe(MessageKind::kAcknowledge, [this](const Message& message) {
    const auto& answer = std::get<model::Acknowledge>(message.body);
    if (answer.outcome == model::Outcome::kSent) return;
    over(answer.request, std::string(to_string(answer.outcome)) + ": " + answer.text);
  });
}

void MessageClient::send(const Address& to, std::string_view type, std::string_view bytes, SentCall sent) {
  if (sent && waiting_.size() >= kMaxWaiting)
    return scheduler_.post([sent = std::move(sent)] { sent("busy: too many messages are under way"); });
  Message message;
  message.destination = to;
  const auto view = base::as_bytes(bytes);
  message.body = model::Opaque{std::string(type), Bytes(view.begin(), view.end())};
  const auto number = gateway_.send(std::move(message));
  if (!sent) return;
  waiting_[number].sent = std::move(sent);
  if (to.island != self_) return;
  // Our own gateway reports only messages that others took.
  lifetime_.post(scheduler_, [this, number] { taken(number); });
}

void MessageClient::taken(std::uint64_t number) {
  const auto found = waiting_.find(number);
  if (found == waiting_.end()) return;
  found->second.objection_time = scheduler_.after(kObjectionTime, [this, number] { over(number, ""); });
}

void MessageClient::over(std::uint64_t number, const std::string& why_not) {
  const auto found = waiting_.extract(number);
  if (found) found.mapped().sent(why_not);
}

tuples::Handle MessageClient::on_message(std::string_view type, MessageCall call) {
  if (type.empty()) return gateway_.subscribe(MessageKind::kOpaque, opaque_call(std::move(call)));
  return gateway_.subscribe_user(type, opaque_call(std::move(call)));
}

}  // namespace rubicon::client
