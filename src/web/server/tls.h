#pragma once

#include <memory>
#include <string>

#include "rubicon/result.hpp"
#include "rubicon/time.hpp"

namespace boost::asio::ssl {
class context;
}

namespace rubicon::web::server {

/// PEM files: the certificate with those that lead to its authority, and its key.
struct TlsFiles {
  std::string certificate, key;

  friend bool operator==(const TlsFiles&, const TlsFiles&) = default;
};

struct TlsSetup {
  std::shared_ptr<boost::asio::ssl::context> context;  ///< TLS 1.2 or later
  WallTime expires;                                    ///< of the certificate
};

/// Reads the files. kNotFound, kIo or kInvalid with the path.
Result<TlsSetup> read_tls(const TlsFiles& files);

}  // namespace rubicon::web::server
