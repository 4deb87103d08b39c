#include "tuples/peis/id_check.h"

#include <utility>

namespace rubicon::tuples::peis {

IdCheck::IdCheck(Scheduler& scheduler, transport::Transports& transports, ConnectMessage own,
                 std::function<void(const Identity&)> confirmed)
    : scheduler_(scheduler),
      transports_(transports),
      own_(std::move(own)),
      confirmed_(std::move(confirmed)),
      cleaning_(scheduler,
                [this] { std::erase_if(questions_, [](const auto& item) { return item.second.is_over; }); }) {}

void IdCheck::ask(const Identity& other, const std::vector<transport::Endpoint>& addresses) {
  for (const auto& [id, question] : questions_) {
    if (question.other.magic == other.magic) return;
  }
  for (const auto& address : addresses) {
    if (questions_.size() < kMaxQuestions) ask(other, address);
  }
}

void IdCheck::ask(const Identity& other, const transport::Endpoint& address) {
  const auto id = ++last_;
  auto& question = questions_[id];
  question.other = other;
  ConnectionCalls calls;
  calls.connected = [this, id] { questions_.at(id).is_connected = true; };
  calls.greeted = [](const ConnectMessage&) { return false; };
  calls.package = [this, id](const Package& package) { end(id, package.header.source == own_.id); };
  calls.closed = [this, id](Ending why, const Error&) {
    end(id, why == Ending::kFailed && questions_.at(id).is_connected);
  };
  calls.room = calls.quiet = [] {};
  question.connection = std::make_unique<Connection>(scheduler_, std::move(calls));
  if (!question.connection->dial(transports_, address, own_)) questions_.erase(id);
}

void IdCheck::end(std::uint64_t id, bool is_there) {
  auto& question = questions_.at(id);
  if (std::exchange(question.is_over, true)) return;
  question.connection->close();
  cleaning_.request();
  if (is_there) confirmed_(question.other);
}

}  // namespace rubicon::tuples::peis
