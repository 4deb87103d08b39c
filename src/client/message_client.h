#pragma once

#include <list>
#include <map>

#include "base/log.h"
#include "base/scheduler.h"
#include "gateway/gateway.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// Sends and receives user messages of this component: a gateway without networks.
class MessageClient {
 public:
  /// After an island accepted a message, it has this long to report that nothing there listens for its type.
  static constexpr Duration kObjectionTime = std::chrono::milliseconds(300);

  MessageClient(Scheduler& scheduler, TupleSpace& space, base::LogSink& log);

  void send(OwnerId to, std::string_view type, std::string_view bytes, SentCall sent) {
    send(Address{to, {}, {}}, type, bytes, std::move(sent));
  }
  void send(const Address& to, std::string_view type, std::string_view bytes, SentCall sent);
  tuples::Handle on_message(std::string_view type, MessageCall call);

 private:
  struct Waiting {
    SentCall sent;
    Timer objection_time;
  };
  /// Messages with a pending outcome; more are refused.
  static constexpr std::size_t kMaxWaiting = 10'000;

  void taken(std::uint64_t number);
  void over(std::uint64_t number, const std::string& why_not);

  Scheduler& scheduler_;
  gateway::Gateway gateway_;
  std::map<std::uint64_t, Waiting> waiting_;  ///< by the message's number
  tuples::Handle answers_;
  OwnerId self_;
  base::Lifetime lifetime_;
};

}  // namespace rubicon::client
