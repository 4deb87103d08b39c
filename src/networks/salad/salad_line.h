#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "networks/salad/salad_options.h"

namespace rubicon::networks::salad {

/// The two sockets of salad.md, section 1: one bound to `rubicon_port` that only receives, one on an ephemeral port
/// that only sends. The options must outlive it; their `any_source` may change.
class SaladLine {
 public:
  struct Callbacks {
    std::function<void()> ready;             ///< both sockets are open, the host is known
    std::function<void(Error)> failed;       ///< the line is closed
    std::function<void(ByteView)> received;  ///< from SALAD
    std::function<void(const Error&)>
        undelivered;                ///< a datagram was not delivered, or the host no longer has an address
    std::function<void()> counted;  ///< a counter changed: a datagram from elsewhere was dropped
  };
  struct Counters {
    std::uint64_t datagrams = 0;     ///< received from SALAD
    std::uint64_t other_source = 0;  ///< received from elsewhere, dropped
    std::uint64_t undelivered = 0;   ///< reported as undelivered by ICMP
  };

  SaladLine(const SaladOptions& options, transport::Transports& transports, Callbacks callbacks);

  /// Binds the sockets and looks up the host; the callback ready() or failed() follows. Does nothing while opening.
  Result<void> open();
  bool ready() const { return ready_; }
  /// Looks up the host again, as SALAD may have moved. Keeps the known addresses if that fails.
  void refresh();
  /// Ends the line as failed() says.
  void give_up(Error why) { fail_line(std::move(why)); }
  /// kUnreachable before ready(), kIo if the system cannot send to SALAD.
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
  Callbacks callbacks_;
  std::unique_ptr<transport::UdpSocket> receiver_, sender_;
  std::unique_ptr<transport::Lookup> lookup_;
  std::vector<std::string> addresses_;  ///< of SALAD's host; datagrams go to the first
  bool ready_ = false;
  std::uint64_t unsent_ = 0;  ///< of sockets that are closed
  Counters counters_;
};

}  // namespace rubicon::networks::salad
