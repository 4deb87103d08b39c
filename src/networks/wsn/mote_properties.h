#pragma once

#include <cstdint>
#include <map>

#include "model/message.h"
#include "model/type_catalogue.h"

namespace rubicon::networks::wsn {

/// The properties of motes, as TypeCatalogue::device_types() lists them: the sampling rate, which the proxy keeps, and
/// the mask of transducers that a mote acknowledged last.
class MoteProperties {
 public:
  /// The catalogue must outlive it.
  explicit MoteProperties(const TypeCatalogue& types) : types_(types) {}

  void declare(std::uint16_t mote, model::Join& join) const;
  /// The mote reads these transducers: what is to be published of it.
  model::Updates reads(std::uint16_t mote, std::uint16_t mask);

 private:
  const TypeCatalogue& types_;
  std::map<std::uint16_t, std::uint16_t> masks_;  ///< of those of which it is known
};

}  // namespace rubicon::networks::wsn
