#pragma once

#include <cstdint>
#include <map>

#include "model/message.h"
#include "model/type_catalogue.h"

namespace rubicon::networks::wsn {

/// The properties of motes that TypeCatalogue::device_types() lists: the sampling rate, which the proxy keeps, and the
/// mask of transducers that the mote acknowledged last.
class MoteProperties {
 public:
  /// The catalogue must outlive it.
  explicit MoteProperties(const TypeCatalogue& types) : types_(types) {}

  /// Adds the properties to a mote's join.
  void declare(std::uint16_t mote, model::Join& join) const;
  /// Records the mask that the mote acknowledged; returns the reading to publish.
  model::Updates set_mask(std::uint16_t mote, std::uint16_t mask);

 private:
  const TypeCatalogue& types_;
  std::map<std::uint16_t, std::uint16_t> masks_;  ///< by mote
};

}  // namespace rubicon::networks::wsn
