#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/virtual_scheduler.h"
#include "network/network.h"
#include "network/supervisor.h"
#include "support/collecting_log.h"
#include "support/memory/memory_transports.h"

namespace rubicon::support {

/// A host in virtual time that keeps all that a network says.
class FakeHost final : public network::NetworkHost {
 public:
  FakeHost() { files.join(net); }
  FakeHost(const FakeHost&) = delete;
  FakeHost& operator=(const FakeHost&) = delete;

  using NetworkHost::deliver;
  void deliver(Message&& message) override { delivered.push_back(std::move(message)); }
  void failed(Error why) override { failures.push_back(std::move(why)); }
  Result<network::TupleWatch> watch_tuple(std::string_view tuple, std::function<void(std::string_view)> call) override {
    followed[std::string(tuple)] = std::move(call);
    return network::TupleWatch(this, [tuple = std::string(tuple)](FakeHost* host) { host->followed.erase(tuple); });
  }
  Result<void> remember(std::string_view name, ByteView value, network::Keep keep) override {
    if (state != nullptr) return state->remember("network", name, value, keep);
    if (forgetful) return NetworkHost::remember(name, value, keep);
    if (auto fits = network::check_memory(name, value); !fits) return fits;
    if (value.empty()) {
      memory.erase(std::string(name));
    } else {
      memory[std::string(name)] = Bytes(value.begin(), value.end());
    }
    return {};
  }
  Result<std::optional<Bytes>> remembered(std::string_view name) override {
    if (state != nullptr) return state->remembered("network", name);
    if (forgetful) return NetworkHost::remembered(name);
    const auto found = memory.find(std::string(name));
    return found == memory.end() ? std::optional<Bytes>() : std::optional(found->second);
  }
  Scheduler& scheduler() override { return time; }
  transport::Transports& transports() override { return *lines; }
  const Log& log() const override { return voice_; }

  /// All bodies of one kind, in order, with the device that said them.
  template <class Body>
  std::vector<std::pair<std::string, Body>> all() const {
    std::vector<std::pair<std::string, Body>> found;
    for (const auto& message : delivered) {
      if (const auto* body = std::get_if<Body>(&message.body)) found.emplace_back(message.source.device, *body);
    }
    return found;
  }

  VirtualScheduler time;
  transport::MemoryNet net{time};  ///< `files` is on it as 127.0.0.1
  transport::MemoryTransports files;
  transport::Transports* lines = &files;  ///< a test may put others here
  CollectingLog words;
  std::vector<Message> delivered;
  std::vector<Error> failures;
  std::map<std::string, Bytes> memory;      ///< what the network remembers; outlives it as the host does
  network::NetworkMemory* state = nullptr;  ///< keeps it instead, if there is one
  bool forgetful = false;                   ///< there is no state file
  std::map<std::string, std::function<void(std::string_view)>> followed;  ///< call one to change that tuple

 private:
  Log voice_{words, "network"};
};

}  // namespace rubicon::support
