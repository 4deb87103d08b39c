#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "base/scheduler.h"
#include "web/exchange.h"
#include "web/server/server.h"

namespace rubicon::web::server {

class PeerStream;

/// A connection, or what carries its conversation.
class Connection {
 public:
  virtual ~Connection() = default;
  /// No request is in progress, or the client is not known yet: the connection may be closed to make room.
  virtual bool idle() const = 0;
  /// Closes it at once, without a call of `closed`.
  virtual void abort() = 0;
};

/// One accepted connection, whatever it speaks at present.
class AcceptedConnection : public Connection {
 public:
  /// IP address of the client.
  virtual const std::string& address() const = 0;
  /// The session whose cookie opened its conversation; 0 = none.
  virtual std::uint64_t session() const = 0;
};

/// What a connection asks of the server behind it. It aborts all its connections before it ends.
class ConnectionHost {
 public:
  virtual ~ConnectionHost() = default;
  /// The head of a request arrived, its body not yet; names the caller in it. A response refuses the request.
  virtual std::optional<Response> admit(Request& head, bool secure) = 0;
  /// As Site::handle.
  virtual std::unique_ptr<Exchange> answer(const Request& request, Respond respond) = 0;
  /// As Site::takes_file.
  virtual bool takes_file(const Request& head) const = 0;
  /// One file is uploaded at a time: what the connection keeps meanwhile; nullptr: another one is.
  virtual std::shared_ptr<void> begin_upload() = 0;
  /// As Site::open.
  virtual std::unique_ptr<Conversation> open(const Request& request, ConversationCallbacks calls) = 0;
  /// The connection ended by itself; the last thing that it does.
  virtual void closed(Connection& connection) = 0;
  virtual const Limits& limits() const = 0;
  virtual Scheduler& scheduler() = 0;
  /// WebSockets offer permessage-deflate (RFC 7692).
  virtual bool compress() const = 0;
};

/// Where WebSockets are opened; all others are refused.
inline constexpr std::string_view kSocketPath = "/api/v1/ws";

/// Begins to read requests from a connection (HTTP/1.1, RFC 9112).
std::shared_ptr<AcceptedConnection> serve_http(ConnectionHost& host, std::unique_ptr<PeerStream> stream);

/// Sends the response without a request, and closes the connection.
std::shared_ptr<AcceptedConnection> refuse_http(ConnectionHost& host, std::unique_ptr<PeerStream> stream,
                                                Response response);

/// Answers the request for a WebSocket (RFC 6455), and then carries its conversation. `ended` is called once, at the
/// end of a turn, and not after abort().
std::shared_ptr<Connection> serve_socket(ConnectionHost& host, std::unique_ptr<PeerStream> stream, Request request,
                                         std::function<void()> ended);

using OpenConversation = std::function<std::unique_ptr<Conversation>(ConversationCallbacks)>;

/// Carries a stream of events whose head `head` has to be sent first. `ended` as above.
std::shared_ptr<Connection> serve_events(ConnectionHost& host, std::unique_ptr<PeerStream> stream, std::string head,
                                         bool chunked, const OpenConversation& open, std::function<void()> ended);

}  // namespace rubicon::web::server
