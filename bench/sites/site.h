#pragma once

#include <string>

#include "rubicon/tuple_space.hpp"

namespace rubicon::bench::sites {

/// What an island with so many devices has: a summary, a network, and for each device the tuples of an island. Each
/// tenth device is a lamp that others may switch, the others are thermometers.
class Site {
 public:
  Site(TupleSpace& space, int devices);

  static int thermometers(int devices);
  /// Its first lamp.
  static std::string lamp_command();

 private:
  Handle lamps_;
};

}  // namespace rubicon::bench::sites
