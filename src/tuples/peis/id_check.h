#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "tuples/peis/connection.h"
#include "tuples/peis/identity.h"

namespace rubicon::tuples::peis {

/// Checks a message that says another component has the id of this one, since the message may be forged: connects to
/// that component. A component closes a connection with its own id and sends nothing (section 6.4, 28). Bounded.
class IdCheck {
 public:
  static constexpr std::size_t kMaxQuestions = 8;  ///< at a time; others are not asked

  /// `confirmed` is called in a later turn than ask().
  IdCheck(Scheduler& scheduler, transport::Transports& transports, ConnectMessage own,
          std::function<void(const Identity&)> confirmed);

  void ask(const Identity& other, const std::vector<transport::Endpoint>& addresses);

 private:
  struct Question {
    Identity other;
    bool is_connected = false, is_over = false;
    std::unique_ptr<Connection> connection;
  };

  void ask(const Identity& other, const transport::Endpoint& address);
  void end(std::uint64_t id, bool is_there);

  Scheduler& scheduler_;
  transport::Transports& transports_;
  ConnectMessage own_;
  std::function<void(const Identity&)> confirmed_;
  std::map<std::uint64_t, Question> questions_;
  std::uint64_t last_ = 0;
  base::OncePerTurn cleaning_;
};

}  // namespace rubicon::tuples::peis
