#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace rubicon::trust::guard {

using Prefix = std::array<std::uint8_t, 6>;

/// What the guard reads of the certificate of a peer. Each text is checked: printable, without separators of its own.
struct Certificate {
  std::string name;          ///< CN of the subject, 1 to 64 of `A-Z a-z 0-9 . _ -`
  std::string roles;         ///< of the URI `rubicon-roles:a,b`; empty = none
  std::string ids;           ///< of the URI `rubicon:<first>-<last>,...`, 8 hexadecimal digits each; empty = none
  std::string serial;        ///< upper-case hexadecimal digits, two for each byte, as `openssl x509 -serial` shows
  std::int64_t expires = 0;  ///< seconds since 1970 UTC
  Prefix prefix{};           ///< the first bytes of the GUIDs of its owner (DDS Security 1.1, 9.3.3)
};

/// Either a certificate or why it cannot be used; never throws but for lack of memory.
struct Reading {
  std::optional<Certificate> certificate;
  std::string reason;
};

/// The first certificate of a PEM text of at most 64 KiB. Extensions and fields that the guard does not use are not
/// looked at: the built-in plug-in has checked signature, purpose and time.
Reading read_certificate(std::string_view pem);

/// The CN that a certificate claims, of at most 64 characters, with `?` for each one that a name may not have; empty =
/// none can be read. For log lines only.
std::string claimed_name(std::string_view pem);

/// `00abc` -> `0ABC`: as in Certificate::serial. Empty = it is no serial number of at most 64 digits.
std::string plain_serial(std::string_view hexadecimal);

}  // namespace rubicon::trust::guard
