#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "web/exchange.h"

namespace rubicon::web::files {

/// The files of the page: those in the program, or those of a folder.
class Page {
 public:
  virtual ~Page() = default;
  /// The answer to a GET; nullopt if there is no such file. The path as it was sent.
  virtual std::optional<Response> find(const Request& request) const = 0;
};

}  // namespace rubicon::web::files
