#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "network/network.h"

namespace rubicon::network {

/// Where delivered messages go: the gateway. Called from inside deliver(); it must only queue.
class MessageSink {
 public:
  virtual ~MessageSink() = default;
  virtual void from_network(const std::string& network, Message&& message) = 0;
};

/// Keeps what networks remember: NetworkHost::remember and remembered, with the id of the network.
class NetworkMemory {
 public:
  virtual ~NetworkMemory() = default;
  virtual Result<void> remember(const std::string& network, std::string_view name, ByteView value, Keep keep) = 0;
  virtual Result<std::optional<Bytes>> remembered(const std::string& network, std::string_view name) = 0;
};

/// Owns the networks of an island, is their host, opens their lines and opens lost ones again after a growing, jittered
/// pause, for ever. Delivers State{kDown, reason} for a lost line. Logs why a line is not up, or up with a reason, when
/// the reason changes (each at most once a minute), and that it is up again. Opens nothing before start(), so that all
/// listeners are attached first.
class Supervisor {
 public:
  Supervisor(IslandId island, Scheduler& scheduler, transport::Transports& transports, base::LogSink& log,
             MessageSink& sink);
  ~Supervisor();

  using ReopenedCall = std::function<void(const Result<void>& outcome)>;

  /// Serves NetworkHost::watch_tuple; without it that is kUnsupported.
  using WatchTuple =
      std::function<Result<TupleWatch>(std::string_view tuple, std::function<void(std::string_view value)> call)>;
  void provide_tuples(WatchTuple watch) { watch_tuple_ = std::move(watch); }

  /// Serves NetworkHost::remember; must outlive the networks.
  void provide_memory(NetworkMemory& memory) { memory_ = &memory; }

  /// kDuplicate for an id already there; else what `make` says.
  Result<void> add(const NetworkType& type, const NetworkConfig& config);
  /// New options for a network of the same type, without losing its line. kUnsupported (or whatever `change` says):
  /// nothing was changed: remove it and add it again.
  Result<void> change(const NetworkConfig& config);
  /// Opens all lines. From now on the lines of added networks are opened at once.
  void start();
  /// Lets all networks say their last words (Network::close), at most kClosingTime long; then calls `closed`, once, in
  /// a later turn. Lost lines are not opened again.
  void close(std::function<void()> closed);
  /// Destroys a network; a State{kDown} is delivered for it.
  void remove(const std::string& id);

  bool has(const std::string& id) const;
  /// nullptr if there is none.
  const Network* find(const std::string& id) const;
  std::vector<std::string> ids() const;
  /// A user wants the next attempt to open the line now, not after the pause. `ended` gets the outcome once, in a later
  /// turn: success once the line is up, kIo with the reason if the attempt failed. If this returns an error,
  /// nothing is tried. kRefused: the line is up, is being opened, or has no attempt to make. kNotFound: there is no
  /// such network. `ended` is not called if the network is removed meanwhile.
  Result<void> reopen(const std::string& id, ReopenedCall ended);
  /// Sets a property of the network itself (Network::control); kNotFound if there is no such network.
  Result<void> control(const std::string& id, std::string_view name, std::string_view text);
  /// To message.destination.network; kNotFound if there is none.
  Result<void> send(const Message& message);

 private:
  class Slot;
  IslandId island_;
  Scheduler& scheduler_;
  transport::Transports& transports_;
  base::LogSink& log_;
  MessageSink& sink_;
  WatchTuple watch_tuple_;
  NetworkMemory* memory_ = nullptr;
  bool started_ = false, closing_ = false;
  std::size_t still_closing_ = 0;
  std::function<void()> closed_;
  Timer closing_timer_;
  std::map<std::string, std::unique_ptr<Slot>> slots_;
};

}  // namespace rubicon::network
