#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/certificate.h"

namespace rubicon::trust {

/// Bytes of the largest signed text, with its signature.
inline constexpr std::size_t kLargestSigned = 1U << 20U;

/// Signs a text as S/MIME with a detached signature, the form that DDS Security 1.1, section 9.4.1 asks for.
Result<std::string> sign_text(std::string_view text, const Certificate& signer, const PrivateKey& key);

/// The text, if exactly this certificate's key signed it, and the document has this certificate and no other. The dates
/// of the signer are the caller's to check. `where` names the source in errors.
Result<std::string> verified_text(std::string_view document, const Certificate& signer, std::string_view where);

}  // namespace rubicon::trust
