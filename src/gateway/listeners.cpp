#include "gateway/listeners.h"

#include <utility>

namespace rubicon::gateway {

Handle Listeners::add(MessageCall call) {
  auto listener = std::make_shared<Listener>(Listener{std::move(call)});
  content_->listeners.push_back(listener);
  return Handle([content = std::weak_ptr<Content>(content_), gone = std::weak_ptr<Listener>(listener)] {
    const auto still = gone.lock();
    if (const auto all = content.lock(); all && still) all->end(still.get());
  });
}

void Listeners::Content::end(const Listener* listener) {
  for (const auto& one : listeners) {
    if (one.get() == listener) one->ended = untidy = true;
  }
  if (depth == 0) tidy();
}

void Listeners::Content::tidy() {
  if (std::exchange(untidy, false)) std::erase_if(listeners, [](const auto& one) { return one->ended; });
}

std::size_t Listeners::call(const Message& message) {
  Content& content = *content_;
  std::size_t heard = 0;
  ++content.depth;
  for (std::size_t i = 0, count = content.listeners.size(); i < count; ++i) {
    Listener& listener = *content.listeners[i];
    if (listener.ended) continue;
    listener.call(message);
    ++heard;
  }
  if (--content.depth == 0) content.tidy();
  return heard;
}

}  // namespace rubicon::gateway
