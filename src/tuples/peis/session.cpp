#include "tuples/peis/session.h"

#include <fmt/format.h>

#include <utility>

namespace rubicon::tuples::peis {

void Session::send(Port port, ByteView body, Done done, SteadyTime ends) {
  if (waiting_.empty() && try_send(port, body, done)) return;
  waiting_bytes_ += body.size();
  waiting_.push_back({port, Bytes(body.begin(), body.end()), std::move(done), ends});
}

/// False: no room.
bool Session::try_send(Port port, ByteView body, const Done& done) {
  const auto sent = context_.node->send(peer_, port, body, done);
  if (sent) return true;
  if (sent.error().code == ErrorCode::kBusy) return false;
  context_.log.debug("send", sent.error().text);
  if (done) context_.scheduler.post([done] { done(Outcome::kHostGone); });
  return true;
}

void Session::ready() {
  const auto now = context_.scheduler.now();
  while (!waiting_.empty()) {
    auto& next = waiting_.front();
    const bool limited = next.ends != SteadyTime::max();
    if (limited && next.ends > now) restamp(next.body, next.ends - now);
    const bool is_over = limited && next.ends <= now;
    if (!is_over && !try_send(next.port, next.body, next.done)) return;
    if (is_over && next.done) context_.scheduler.post([done = next.done] { done(Outcome::kNotSent); });
    waiting_bytes_ -= next.body.size();
    waiting_.pop_front();
  }
  send_due();
}

void Session::send_due() {
  while (!is_full() && send_next()) {
  }
}

void Session::restamp(Bytes&, Duration) {}

void Session::deliver(const Change& change) {
  if (context_.listener) context_.listener->on_changes(peer_, {&change, 1});
}

void Session::end_snapshot(std::uint32_t subscription) {
  later([this, subscription] { deliver(SnapshotEnd{subscription}); });
}

void Session::bad(const Error& error) {
  ++context_.counters.bad_messages;
  context_.log.warning("message of " + name(), fmt::format("{}: {}: dropped", name(), error.text));
}

std::string Session::name() const {
  return fmt::format("component {}", number(peer_));
}

}  // namespace rubicon::tuples::peis
