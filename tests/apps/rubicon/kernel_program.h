#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "transport/asio_scheduler.h"
#include "transport/host_names.h"
#include "transport/local_transports.h"
#include "tuples/peis/kernel_peer.h"
#include "tuples/peis/translation.h"
#include "tuples/peis/tuple_wire.h"

namespace rubicon::cli {

/// A simulated kernel of PEIS on the sockets of this machine, in a thread of its own. It pushes its tuples to those who
/// subscribe to them, and takes remote sets.
class KernelProgram {
 public:
  using Tuples = std::map<std::string, std::string>;
  using Change = std::function<void(tuples::peis::KernelPeer&)>;

  /// `prepare` changes the kernel before it listens and announces itself.
  KernelProgram(std::uint32_t id, std::uint16_t port, Tuples tuples, Change prepare = {})
      : id_(id), tuples_(std::move(tuples)), thread_([this] { loop_.run(); }) {
    on_loop([&] {
      kernel_ = std::make_unique<tuples::peis::KernelPeer>(loop_.scheduler(), sockets_, id, port);
      const auto host = transport::host_name();
      kernel_->host_name = host.substr(0, host.find('.'));
      kernel_->on_message = [this](const auto& message) { received(message); };
      kernel_->listen();
      if (prepare) prepare(*kernel_);
      kernel_->announce();
    });
  }
  ~KernelProgram() {
    on_loop([this] { kernel_.reset(); });
    loop_.stop();
    thread_.join();
  }
  KernelProgram(const KernelProgram&) = delete;
  KernelProgram& operator=(const KernelProgram&) = delete;

  void change(const Change& change) {
    on_loop([&] { change(*kernel_); });
  }
  std::string value(const std::string& key) {
    std::string found;
    on_loop([&] { found = tuples_[key]; });
    return found;
  }
  /// Sets a tuple of another component, which is routable.
  void set_remote(std::uint32_t owner, const std::string& key, const std::string& value) {
    on_loop([&] {
      kernel_->send(owner, tuples::peis::Port::kSetRemote, text_of([&] {
                      const auto data = value + '\0';
                      return tuples::peis::write_set_remote(tuple(OwnerId(owner), key, data, 0));
                    }));
    });
  }
  bool routable(std::uint32_t id) {
    bool is = false;
    on_loop([&] { is = kernel_->routable(id); });
    return is;
  }

 private:
  void on_loop(const std::function<void()>& call) {
    std::promise<void> done;
    loop_.scheduler().post([&] {
      call();
      done.set_value();
    });
    done.get_future().wait();
  }
  template <class Write>
  static std::string text_of(const Write& write) {
    const auto bytes = write();
    return std::string(base::as_text(bytes));
  }
  /// Views refer to the arguments.
  tuples::peis::NetworkTuple tuple(OwnerId owner, std::string_view key, std::string_view data, std::uint32_t number) {
    tuples::peis::NetworkTuple out;
    out.owner = owner;
    out.creator = OwnerId(id_);
    out.key = key;
    out.write_time = loop_.scheduler().wall_now();
    out.user_time = out.expire_time = WallTime{};
    out.encoding = tuples::peis::Encoding::kAscii;
    out.media_type = "text/plain";
    out.data = data;
    out.sequence = number;
    return out;
  }
  void push(std::uint32_t to, const std::string& key, OwnerId creator) {
    const auto data = tuples_.at(key) + '\0';
    auto out = tuple(OwnerId(id_), key, data, numbers_[key]);
    out.creator = creator;
    kernel_->send(to, tuples::peis::Port::kPush, text_of([&] { return tuples::peis::write_push(out); }));
  }
  void received(const tuples::peis::KernelPeer::Received& message) {
    using tuples::peis::Port;
    const auto body = base::as_bytes(message.body);
    if (message.header.port == Port::kSubscribe) subscribed(number(message.header.source), body);
    if (message.header.port == Port::kSetRemote) was_set(body);
  }
  void subscribed(std::uint32_t subscriber, ByteView body) {
    const auto read = tuples::peis::read_subscribe(body);
    if (!read) return;
    const std::string pattern(read->prototype.key);
    subscribers_[subscriber].push_back(pattern);
    for (const auto& [key, value] : tuples_) {
      if (covers(pattern, key)) push(subscriber, key, OwnerId(id_));
    }
  }
  void was_set(ByteView body) {
    const auto read = tuples::peis::read_set_remote(body);
    if (!read || !read->data) return;
    const std::string key(read->key);
    tuples_[key] = std::string(read->data->substr(0, read->data->find('\0')));
    ++numbers_[key];
    for (const auto& [subscriber, patterns] : subscribers_) {
      for (const auto& pattern : patterns) {
        if (!covers(pattern, key)) continue;
        push(subscriber, key, *read->creator);
        break;
      }
    }
  }
  static bool covers(const std::string& pattern, const std::string& key) {
    return pattern.empty() || tuples::peis::matches_folded(pattern, key);
  }

  std::uint32_t id_;
  Tuples tuples_;
  std::map<std::string, std::uint32_t> numbers_;
  std::map<std::uint32_t, std::vector<std::string>> subscribers_;
  transport::Loop loop_;
  transport::LocalTransports sockets_{loop_};
  std::unique_ptr<tuples::peis::KernelPeer> kernel_;
  std::thread thread_;
};

}  // namespace rubicon::cli
