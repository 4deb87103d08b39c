#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace rubicon::web::access {

/// Which names the server answers to, and whose pages may use it. A page of another site that a browser shows can make
/// the browser send requests here, and a name of that site can be made to lead to our address (DNS rebinding).
struct OriginRules {
  std::vector<std::string> hosts;    ///< names besides IP addresses and `localhost`
  std::vector<std::string> origins;  ///< `https://hall.lan`: other pages, and the page behind a proxy

  /// Whether Host names an IP address, `localhost`, or one of `hosts`; the port does not count.
  bool is_own_host(std::string_view host) const;
  /// Whether a page of this origin (RFC 6454) is ours: it has our Host and scheme, or is one of `origins`.
  bool is_own_origin(std::string_view origin, std::string_view host, bool secure) const;
  /// Whether `origins` lists it.
  bool is_listed(std::string_view origin) const;
};

}  // namespace rubicon::web::access
