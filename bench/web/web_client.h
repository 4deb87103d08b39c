#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "frame/figures.h"

namespace rubicon::bench::web {

/// A client of a WebSocket (RFC 6455) at 127.0.0.1 that waits where it has to: it costs as little as possible. All
/// calls throw if the connection is lost.
class WebClient {
 public:
  /// `protocol`: the subprotocol that it asks for; empty = none.
  WebClient(int port, std::string_view path, std::string_view protocol = {});
  ~WebClient();
  WebClient(const WebClient&) = delete;
  WebClient& operator=(const WebClient&) = delete;

  void send_text(std::string_view text) { send(kText, text); }
  void send_bytes(std::string_view bytes) { send(kBinary, bytes); }
  /// The next message, valid until the next call; nullopt if none is complete by then.
  std::optional<std::string_view> next(Clock::time_point until);
  /// Takes what has arrived, and does not look at it. Gives the number of bytes. next() cannot be called afterwards.
  std::size_t discard();
  int descriptor() const { return socket_; }

 private:
  static constexpr unsigned char kText = 1, kBinary = 2, kPing = 9, kPong = 10;

  void send(unsigned char opcode, std::string_view content);
  void write(std::string_view bytes) const;
  bool read(Clock::time_point until);
  /// Takes one whole frame from what was read.
  bool take_frame();

  int socket_;
  std::string input_, message_;
  std::size_t at_ = 0;  ///< what of the input was used
  bool complete_ = false;
};

/// The body of the answer to `GET target`; throws unless its status is 200. Asks again when the server
/// limits the rate (429).
std::string http_get(int port, const std::string& target);

}  // namespace rubicon::bench::web
