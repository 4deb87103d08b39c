#pragma once

#include <array>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "web/server/client.h"

namespace rubicon::web::server {

/// The other end of a TLS connection, which trusts every certificate and keeps its serial number.
class TlsClient {
 public:
  TlsClient(WebWorld& world, const transport::Endpoint& server, int newest = TLS1_3_VERSION)
      : world_(world), context_(boost::asio::ssl::context::tls_client), stream_(world.context, context_) {
    SSL_set_max_proto_version(stream_.native_handle(), newest);
    if (newest < TLS1_2_VERSION) {
      SSL_set_security_level(stream_.native_handle(), 0);
      SSL_set_min_proto_version(stream_.native_handle(), newest);
    }
    stream_.next_layer().connect({boost::asio::ip::make_address(server.address), server.port});
    stream_.async_handshake(boost::asio::ssl::stream_base::client, [this](const auto& error) {
      failed = static_cast<bool>(error);
      done = true;
    });
  }

  bool shakes_hands() {
    return world_.until([&] { return done; }) && !failed;
  }
  long serial() {
    const std::unique_ptr<X509, void (*)(X509*)> peer(SSL_get1_peer_certificate(stream_.native_handle()), X509_free);
    return ASN1_INTEGER_get(X509_get0_serialNumber(peer.get()));
  }
  bool gets(const std::string& request, std::string_view part) {
    boost::asio::async_write(stream_, boost::asio::buffer(request), [](const auto&, std::size_t) {});
    read();
    return world_.until([&] { return received.find(part) != received.npos || closed; }) &&
           received.find(part) != received.npos;
  }

  std::string received;
  bool done = false, failed = false, closed = false;

 private:
  void read() {
    stream_.async_read_some(boost::asio::buffer(piece_), [this](const auto& error, std::size_t size) {
      received.append(piece_.data(), size);
      if (error) {
        closed = true;
      } else {
        read();
      }
    });
  }

  WebWorld& world_;
  boost::asio::ssl::context context_;
  boost::asio::ssl::stream<boost::asio::ip::tcp::socket> stream_;
  std::array<char, 4096> piece_{};
};

}  // namespace rubicon::web::server
