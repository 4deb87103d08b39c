#pragma once

#include <string>
#include <vector>

#include "components/node.h"
#include "frame/figures.h"

namespace rubicon::bench {

/// How much is measured.
struct Plan {
  std::uint32_t domain = 0;
  std::string engine{};     ///< Meeting::engine
  int rounds = 5;           ///< of each measurement; medians are reported
  double seconds = 3;       ///< of each round that is measured by time
  bool is_quick = false;    ///< smaller sizes: a test of the program, not a measurement
  bool is_private = false;  ///< this process is in a network of its own

  /// A unique meeting place.
  Meeting new_meeting() const;
};

/// The JSON object of results: figures by name, their targets, and details.
class Report {
 public:
  void figure(const std::string& name, Json value) { figures_[name] = std::move(value); }
  void target(const std::string& name, const std::string& text, bool met) {
    targets_[name] = {{"target", text}, {"met", met}};
  }
  void detail(const std::string& name, Json value) { details_[name] = std::move(value); }
  Json json() const;

 private:
  Json figures_ = Json::object(), targets_ = Json::object(), details_ = Json::object();
};

}  // namespace rubicon::bench
