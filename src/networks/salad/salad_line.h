#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "networks/salad/salad_options.h"

namespace rubicon::networks::salad {

/// The two sockets of salad.md, section 1: one bound to `rubicon_port` that only receives, one on an ephemeral port
/// that only sends. The options must outlive it; `any_source` may change meanwhile.
class SaladLine {
 public:
  struct Calls {
    std::function<void()> ready;                    ///< both sockets are up, the host is known
    std::function<void(Error)> failed;              ///< closed again
    std::function<void(ByteView)> received;         ///< from SALAD
    std::function<void(const Error&)> undelivered;  ///< what was sent met nobody, or the host cannot be found any more
    std::function<void()> counted;                  ///< something from elsewhere was dropped
  };
  struct Counters {
    std::uint64_t datagrams = 0;     ///< received from SALAD
    std::uint64_t other_source = 0;  ///< received from elsewhere, dropped
    std::uint64_t undelivered = 0;   ///< sent in vain, as far as ICMP tells
  };

  SaladLine(const SaladOptions& options, transport::Transports& transports, Calls calls);

  /// Binds, then looks the host up; ready() or failed() follows. Harmless while open or opening.
  Result<void> open();
  bool ready() const { return ready_; }
  /// Looks the host up again: SALAD may have moved. What was known stays if that fails.
  void refresh();
  /// kUnreachable before ready().
  Result<void> send(std::string_view datagram);

  /// Of the receiving socket; 0 while closed.
  std::uint16_t own_port() const { return receiver_ ? receiver_->local().port : std::uint16_t{0}; }
  std::uint64_t unsent() const { return unsent_ + (sender_ ? sender_->dropped() : 0); }
  const Counters& counters() const { return counters_; }

 private:
  Result<void> open_sockets();
  void close();
  void look_up();
  void looked_up(Result<std::vector<std::string>> addresses);
  void receive(const transport::Endpoint& from, ByteView bytes);
  void fail_line(Error why);

  const SaladOptions& options_;
  transport::Transports& transports_;
  Calls calls_;
  std::unique_ptr<transport::UdpSocket> receiver_, sender_;
  std::unique_ptr<transport::Lookup> lookup_;
  std::vector<std::string> addresses_;  ///< of SALAD's host; the first is sent to
  bool ready_ = false;
  std::uint64_t unsent_ = 0;  ///< of sockets closed since
  Counters counters_;
};

}  // namespace rubicon::networks::salad
