#pragma once

#include <array>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "gateway/gateway.h"

namespace rubicon::gateway {

/// Who wants to hear of which messages. Calls may subscribe and unsubscribe anybody, themselves included.
class Listeners {
 public:
  Handle subscribe(MessageKind kind, MessageCall call);
  Handle subscribe_user(std::string_view type, MessageCall call);

  /// False if nobody listens.
  bool tell(const Message& message);

 private:
  struct Listener {
    MessageCall call;
    bool ended = false;
  };
  using List = std::vector<std::shared_ptr<Listener>>;
  struct Lists {
    std::array<List, std::variant_size_v<model::Body>> by_kind;
    std::unordered_map<std::string, List> by_type;
  };
  static Handle add(List& list, const std::shared_ptr<Lists>& lists, MessageCall call);
  static bool tell(List& list, const Message& message);

  std::shared_ptr<Lists> lists_ = std::make_shared<Lists>();
};

}  // namespace rubicon::gateway
