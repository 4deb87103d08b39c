#pragma once

#include <gtest/gtest.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "base/virtual_scheduler.h"
#include "support/collecting_log.h"
#include "web/server/server.h"

namespace rubicon::web::server {

using namespace std::chrono_literals;

/// Real sockets of loopback, and time that advances only when a test advances it.
struct WebWorld {
  /// Lets sockets and calls work until it is so; false after a minute of real time.
  bool until(const std::function<bool()>& so) {
    const auto end = std::chrono::steady_clock::now() + 60s;
    while (!so()) {
      if (std::chrono::steady_clock::now() > end) return false;
      context.restart();
      context.run_one_for(1ms);
      context.poll();
      time.run_ready();
    }
    return true;
  }
  /// Advances the time; what arrived before is handled before.
  void pass(Duration span) {
    settle();
    time.run_for(span);
    settle();
  }
  /// Until loopback is quiet.
  void settle() {
    for (int quiet = 0; quiet < 3;) {
      context.restart();
      time.run_ready();
      quiet = context.run_one_for(2ms) > 0 ? 0 : quiet + 1;
    }
    time.run_ready();
  }

  /// What is there now, without waiting for more.
  void settle_briefly() {
    for (int round = 0; round < 4; ++round) {
      context.restart();
      context.poll();
      time.run_ready();
    }
  }

  boost::asio::io_context context;
  VirtualScheduler time;
};

/// A client that sends bytes as they are and keeps all that comes.
class RawClient {
 public:
  /// From any address, or from `source`.
  RawClient(WebWorld& world, const transport::Endpoint& server, const std::string& source = {})
      : world_(world), socket_(world.context) {
    if (!source.empty()) {
      const boost::asio::ip::tcp::endpoint own{boost::asio::ip::make_address(source), 0};
      socket_.open(own.protocol());
      socket_.bind(own);
    }
    socket_.connect({boost::asio::ip::make_address(server.address), server.port});
    socket_.non_blocking(true);
    receive();
  }

  void send(std::string_view bytes) {
    boost::system::error_code ignored;
    const auto text = std::make_shared<std::string>(bytes);
    boost::asio::async_write(socket_, boost::asio::buffer(*text), [text](const auto&, std::size_t) {});
  }
  /// True when the text has come.
  bool gets(std::string_view text) {
    return world_.until([&] { return received.find(text) != received.npos || closed; }) &&
           received.find(text) != received.npos;
  }
  bool is_closed() {
    return world_.until([&] { return closed; });
  }
  void close() { socket_.close(); }
  /// While held, it reads nothing.
  void hold(bool held) {
    held_ = held;
    if (held) return socket_.cancel();
    receive();
  }

  std::string received;
  bool closed = false;

 private:
  void receive() {
    socket_.async_read_some(boost::asio::buffer(piece_), [this](const auto& error, std::size_t size) {
      if (error == boost::asio::error::operation_aborted || held_) return;
      received.append(piece_.data(), size);
      if (error) {
        closed = true;
      } else {
        receive();
      }
    });
  }

  WebWorld& world_;
  boost::asio::ip::tcp::socket socket_;
  std::array<char, 16384> piece_{};
  bool held_ = false;
};

}  // namespace rubicon::web::server
