#pragma once

#include <list>
#include <map>

#include "base/lifetime.h"
#include "base/log.h"
#include "gateway/gateway.h"
#include "rubicon/client.hpp"

namespace rubicon::client {

/// User messages to and from this component: a gateway without networks.
class PostOffice {
 public:
  /// After an island took a message it has so long to say that nobody there listens.
  static constexpr Duration kObjectionTime = std::chrono::milliseconds(300);

  PostOffice(Scheduler& scheduler, TupleSpace& space, base::LogSink& log);

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
  /// Messages whose outcome somebody waits for; more are refused.
  static constexpr std::size_t kMostWaiting = 10'000;

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
