#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/log.h"
#include "base/text.h"
#include "transport/transports.h"
#include "tuples/mqtt/topics.h"

namespace rubicon::tuples::mqtt {

/// A broker, and the user that this process is there.
struct SpaceBroker {
  transport::MqttOptions line;   ///< without client id, will and keep-alive time
  std::string user{kAnonymous};  ///< check_user()
};

/// The first one and, with its user, password and TLS, those at other addresses.
std::vector<SpaceBroker> with_spare(SpaceBroker first, const std::vector<base::HostPort>& spare);

/// The connection to the first of some brokers that is there. Where that one fails for kPatience, the next is tried;
/// from a later one it goes back to an earlier one that is there again.
class Uplink {
 public:
  struct Callbacks {
    /// A connection as that user begins; returns what the broker should publish when it breaks.
    std::function<transport::MqttWill(const std::string& user)> begins;
    std::function<void(const transport::MqttConnack& connack)> connected;
    std::function<void(const transport::MqttMessage& message)> received;
    std::function<void(const transport::MqttOutcome& outcome)> taken;
    std::function<void(const transport::MqttOutcome& outcome, const Error& why)> not_taken;
    /// The connection ends normally right after this, for an earlier broker.
    std::function<void()> leaves;
    /// The connection broke, after `connected`.
    std::function<void()> lost;
  };
  static constexpr Duration kPatience = std::chrono::seconds(10), kLookBack = std::chrono::minutes(1);

  /// At least one broker.
  Uplink(std::vector<SpaceBroker> brokers, Duration keep_alive, Scheduler& scheduler, transport::Transports& transports,
         base::LimitedLog& log, Callbacks calls);

  /// Begins to connect, and tries again as long as it lives. kInvalid for options that no broker can accept.
  Result<void> open();
  /// nullptr: not connected.
  transport::MqttLine* line() const { return connected_ ? line_.get() : nullptr; }
  const SpaceBroker& broker() const { return brokers_[at_]; }
  /// Why there is no connection; empty: there is one, or the first attempt goes on.
  const std::string& trouble() const { return trouble_; }

 private:
  Result<void> connect();
  transport::MqttCallbacks calls();
  void on_connected(const transport::MqttConnack& connack);
  void on_failed(const Error& why);
  void connect_later();
  void look_back(std::size_t number);
  void go_back(std::size_t number);
  std::string name(std::size_t number) const;

  std::vector<SpaceBroker> brokers_;
  Duration keep_alive_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  base::LimitedLog& log_;
  Callbacks callbacks_;
  std::size_t at_ = 0;
  std::unique_ptr<transport::MqttLine> line_;
  std::unique_ptr<transport::MqttLine> scout_;  ///< asks whether an earlier broker is there
  bool connected_ = false;
  std::size_t refusals_ = 0;  ///< one after the other
  SteadyTime failing_since_{};
  Duration pause_;
  std::string trouble_;
  Timer retry_, look_back_;
};

/// A random time from one half to one and a half of the given one, so that clients that began together do not repeat
/// together.
Duration about(Duration time);

}  // namespace rubicon::tuples::mqtt
