#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "native/subscription.h"
#include "rubicon/client.hpp"

namespace rubicon::python {

namespace py = pybind11;

/// A client of the tuple space for the event loop of a Python program, which calls poll() whenever the descriptor is
/// readable. What the client reports is kept until the client has returned; Python is called then, so that nothing that
/// Python does or raises happens inside the client. Only judges are asked in between.
///
/// Times are seconds, owners and numbers ints. Calls raise rubicon.Error. All calls are on one thread, with the GIL.
class Component {
 public:
  explicit Component(const py::dict& options);
  ~Component();
  Component(const Component&) = delete;
  Component& operator=(const Component&) = delete;

  std::uint32_t id() const { return number(client_->id()); }
  int descriptor() const { return client_->descriptor(); }
  /// Does what is due, then calls back. Raises what a callback raised; the others are called all the same, next time.
  void poll();
  /// Subscriptions, judges and listeners end. Every other call is an error from then on.
  void close();

  py::list islands() const;
  /// `call(list of {owner, key, value, media, sequence, write, user})`, once.
  void read(const std::string& pattern, double timeout, py::function call);
  /// `call(frame)` for each frame, in the form of docs/api.md. Ends with end().
  std::uint64_t subscribe(const std::string& pattern, const py::dict& flow, bool full, py::function call);
  /// Sets, or appends. `call(answer)` in the form of the API: {ok, error} or {state, reason, request, until, sequence,
  /// final}.
  void write(std::uint32_t owner, const std::string& key, const std::string& value, const py::dict& options,
             py::function call);
  /// An own tuple: its sequence number after the set.
  std::uint64_t own(const std::string& key, const std::string& value, const std::string& media_type, double lifetime);
  void erase(const std::string& key);
  /// `call(set)` decides about the sets of others: None accepts, a text refuses and says why. Ends with end().
  std::uint64_t judge(const std::string& pattern, bool appends, py::function call);
  void send(std::uint32_t to, const std::string& type, const std::string& data, const std::string& network,
            const std::string& device, py::function call);
  /// `call(message)`, in the form of the API with `value` as bytes. Ends with end().
  std::uint64_t listen(const std::string& type, py::function call);
  void end(std::uint64_t what);

 private:
  void check() const;
  std::uint64_t keep(Handle handle);
  void later(std::function<void()> call) { due_.push_back(std::move(call)); }
  void command(std::uint32_t owner, const std::string& key, const std::string& value, const py::dict& options,
               const py::function& call);
  void peer_changed(OwnerId peer, PeerEvent event);

  std::unique_ptr<Client> client_;
  std::vector<std::function<void()>> due_;
  std::map<std::uint64_t, std::unique_ptr<Subscription>> subscriptions_;
  std::map<std::uint64_t, Handle> handles_;
  Handle peers_;
  std::uint64_t last_ = 0;
  bool inside_ = false;  ///< the client runs
};

}  // namespace rubicon::python
