#pragma once

#include <chrono>
#include <cstddef>

#include "rubicon/time.hpp"

namespace rubicon::web::server {

/// What one client may cost, and for how long.
struct Limits {
  std::size_t connections = 64;
  std::size_t refused = 8;                        ///< further connections that are refused with an answer
  std::size_t target = std::size_t{8} << 10;      ///< bytes of the request target
  std::size_t head = std::size_t{16} << 10;       ///< bytes of request line and fields
  std::size_t body = std::size_t{1} << 20;        ///< bytes
  std::size_t message = std::size_t{64} << 10;    ///< bytes of an incoming WebSocket message
  std::size_t ahead = 64;                         ///< messages that are read while the client takes none of ours
  Duration handshake = std::chrono::seconds(10);  ///< of TLS
  Duration head_time = std::chrono::seconds(10);  ///< from the first byte of a request to the end of its head
  Duration body_time = std::chrono::seconds(30);
  Duration answer = std::chrono::minutes(10);   ///< for the site to answer
  Duration idle = std::chrono::seconds(60);     ///< between requests
  Duration stalled = std::chrono::seconds(30);  ///< a client that takes nothing for this long is closed
  Duration linger = std::chrono::seconds(2);    ///< for the client to read a refusal before its connection is closed
  Duration ping = std::chrono::seconds(20);     ///< between WebSocket pings
};

}  // namespace rubicon::web::server
