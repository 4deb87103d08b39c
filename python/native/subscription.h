#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::python {

namespace py = pybind11;

/// Makes frames, as a WebSocket of the API has them (docs/api.md, Subscribe), of the events of one subscription.
class Subscription {
 public:
  Subscription(TupleSpace& space, const Pattern& pattern, const Flow& flow, bool full, py::function call);

  void peer_changed(OwnerId peer, bool present);
  bool due() const { return due_; }
  /// Calls with all that came since the last frame. Raises what the call raises.
  void flush();

 private:
  void take(const Event& event);
  void set(const TupleView& tuple);
  void add_snapshot(OwnerId owner);

  bool full_;
  py::function call_;
  bool due_ = false;
  std::unordered_map<std::string, std::uint32_t> numbers_;  ///< by `OWNER:KEY`
  std::uint32_t last_number_ = 0;
  std::string name_;  ///< of the event that is taken; kept for its memory
  py::dict keys_;
  py::list sets_, gone_, present_, absent_;
  std::vector<OwnerId> snapshots_;
  Handle handle_;  ///< last, so that no event finds the others gone
};

/// A text, or None for bytes that are none.
py::object text_or_none(std::string_view bytes);
double seconds_of(WallTime time);

}  // namespace rubicon::python
