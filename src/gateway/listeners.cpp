#include "gateway/listeners.h"

#include <algorithm>

namespace rubicon::gateway {

Handle Listeners::add(List& list, const std::shared_ptr<Lists>& lists, MessageCall call) {
  auto listener = std::make_shared<Listener>(Listener{std::move(call)});
  list.push_back(listener);
  return Handle([listener, alive = std::weak_ptr(lists)] {
    listener->ended = true;  // swept by the next message, so that a running walk is not disturbed
    if (alive.expired()) listener->call = nullptr;
  });
}

Handle Listeners::subscribe(MessageKind kind, MessageCall call) {
  return add(lists_->by_kind[static_cast<std::size_t>(kind)], lists_, std::move(call));
}

Handle Listeners::subscribe_user(std::string_view type, MessageCall call) {
  return add(lists_->by_type[std::string(type)], lists_, std::move(call));
}

bool Listeners::tell(List& list, const Message& message) {
  bool told = false;
  bool ended = false;
  for (std::size_t i = 0, present = list.size(); i < present; ++i) {
    const auto listener = list[i].get();
    ended |= listener->ended;
    if (listener->ended) continue;
    const auto keep = list[i];
    keep->call(message);
    told = true;
  }
  if (ended) std::erase_if(list, [](const auto& listener) { return listener->ended; });
  return told;
}

bool Listeners::tell(const Message& message) {
  bool told = tell(lists_->by_kind[message.body.index()], message);
  const auto* opaque = std::get_if<model::Opaque>(&message.body);
  if (!opaque) return told;
  const auto found = lists_->by_type.find(opaque->type);
  if (found == lists_->by_type.end()) return told;
  told |= tell(found->second, message);
  if (found->second.empty()) lists_->by_type.erase(found);
  return told;
}

}  // namespace rubicon::gateway
