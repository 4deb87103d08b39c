#pragma once

#include <memory>
#include <vector>

#include "gateway/gateway.h"

namespace rubicon::gateway {

/// The subscribers to one kind of message. They may subscribe and unsubscribe, themselves included, during a call.
class Listeners {
 public:
  [[nodiscard]] Handle add(MessageCall call);
  /// Returns how many listeners were called.
  std::size_t call(const Message& message);
  bool empty() const { return content_->listeners.empty(); }

 private:
  struct Listener {
    MessageCall call;
    bool ended = false;
  };
  /// Shared with the handles, which may outlive the gateway.
  struct Content {
    std::vector<std::shared_ptr<Listener>> listeners;
    int depth = 0;
    bool untidy = false;
    void end(const Listener* listener);
    void tidy();
  };
  std::shared_ptr<Content> content_ = std::make_shared<Content>();
};

}  // namespace rubicon::gateway
