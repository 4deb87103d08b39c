#pragma once

#include <fmt/format.h>

#include <string>

namespace rubicon::bench {

/// An ETS export (CSV) of this many group addresses: switches, their states, dimmers and temperatures.
inline std::string export_of(int addresses) {
  std::string text =
      "\"Group name\";\"Address\";\"Central\";\"Unfiltered\";\"Description\";\"DatapointType\";\"Security\"\r\n";
  static constexpr const char* kTypes[] = {"DPST-1-1", "DPST-1-11", "DPST-5-1", "DPST-9-1"};
  static constexpr const char* kWords[] = {"switch", "switch status", "brightness", "temperature"};
  for (int i = 1; i <= addresses; ++i) {
    text += fmt::format("\"Room {} {}\";\"{}/{}/{}\";\"\";\"\";\"\";\"{}\";\"Auto\"\r\n", i / 4, kWords[i % 4], i >> 11,
                        i >> 8 & 7, i & 255, kTypes[i % 4]);
  }
  return text;
}

}  // namespace rubicon::bench
