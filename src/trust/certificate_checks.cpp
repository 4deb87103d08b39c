#include <fmt/format.h>
#include <openssl/err.h>

#include <ctime>

#include "base/printable.h"
#include "trust/certificate.h"

namespace rubicon::trust {

namespace {

using StoreHandle = std::unique_ptr<X509_STORE, Releaser<X509_STORE_free>>;
using StoreContextHandle = std::unique_ptr<X509_STORE_CTX, Releaser<X509_STORE_CTX_free>>;

constexpr WallTime kFirstDay = std::chrono::sys_days(std::chrono::year(2020) / 1 / 1);

std::time_t seconds_of(WallTime time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

/// nullptr if the chain holds, else the reason.
const char* chain_fault(const Certificate& certificate, const Certificate& authority, WallTime now) {
  const StoreHandle store(X509_STORE_new());
  const StoreContextHandle context(X509_STORE_CTX_new());
  if (store == nullptr || context == nullptr || X509_STORE_add_cert(store.get(), authority.get()) != 1 ||
      X509_STORE_CTX_init(context.get(), store.get(), certificate.get(), nullptr) != 1)
    return "OpenSSL cannot check it";
  auto* parameters = X509_STORE_CTX_get0_param(context.get());
  X509_VERIFY_PARAM_set_time(parameters, seconds_of(now));
  X509_VERIFY_PARAM_set_flags(parameters, X509_V_FLAG_CHECK_SS_SIGNATURE | X509_V_FLAG_X509_STRICT);
  X509_STORE_CTX_set_purpose(context.get(), X509_PURPOSE_SSL_CLIENT);
  const bool good = X509_verify_cert(context.get()) == 1;
  ERR_clear_error();
  return good ? nullptr : X509_verify_cert_error_string(X509_STORE_CTX_get_error(context.get()));
}

bool is_authority_of(AuthorityKind kind, const Certificate& certificate) {
  auto* raw = certificate.get();
  const auto flags = X509_get_extension_flags(raw);
  if ((flags & (EXFLAG_INVALID | EXFLAG_CRITICAL)) != 0) return false;
  const auto usage = X509_get_key_usage(raw);
  const bool certifies = (flags & EXFLAG_CA) != 0;
  if (kind == AuthorityKind::kIdentities) return certifies && usage == (KU_KEY_CERT_SIGN | KU_CRL_SIGN);
  return !certifies && usage == KU_DIGITAL_SIGNATURE && X509_get_extended_key_usage(raw) == XKU_SMIME;
}

}  // namespace

std::string date_text(WallTime time) {
  const auto seconds = seconds_of(time);
  std::tm parts{};
  if (::gmtime_r(&seconds, &parts) == nullptr) return fmt::format("{} s after 1970", seconds);
  return fmt::format("{:04}-{:02}-{:02} {:02}:{:02} UTC", parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday,
                     parts.tm_hour, parts.tm_min);
}

Result<void> check_clock(WallTime now, std::string_view where) {
  if (now >= kFirstDay) return {};
  return fail(ErrorCode::kExpired,
              fmt::format("{}: the clock of this host says {}: expected a time after 2020; set the clock", where,
                          date_text(now)));
}

Result<void> check_dates(const Certificate& certificate, WallTime now, std::string_view where) {
  if (auto clock = check_clock(now, where); !clock) return clock;
  if (now < certificate.begins())
    return fail(ErrorCode::kExpired,
                fmt::format("{}: {} is not valid before {}, and the clock says {}", where, certificate.subject(),
                            date_text(certificate.begins()), date_text(now)));
  if (now < certificate.ends()) return {};
  return fail(ErrorCode::kExpired,
              fmt::format("{}: {} ended on {}, and the clock says {}: renew it, or set the clock", where,
                          certificate.subject(), date_text(certificate.ends()), date_text(now)));
}

Result<void> check_issued(const Certificate& certificate, const Certificate& authority, WallTime now,
                          std::string_view where) {
  if (auto dated = check_dates(certificate, now, where); !dated) return dated;
  if (const auto* fault = chain_fault(certificate, authority, now); fault != nullptr)
    return fail(ErrorCode::kInvalid, fmt::format("{}: {} was not certified by this realm ({}): {}", where,
                                                 certificate.subject(), authority.organisation(), fault));
  const auto flags = X509_get_extension_flags(certificate.get());
  if (X509_get_extended_key_usage(certificate.get()) != (XKU_SSL_CLIENT | XKU_SSL_SERVER) ||
      X509_get_key_usage(certificate.get()) != KU_DIGITAL_SIGNATURE || (flags & EXFLAG_CA) != 0)
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} is not the certificate of a member: expected one for signatures of TLS clients and "
                            "servers",
                            where, certificate.subject()));
  if (certificate.organisation() != authority.organisation() || authority.organisation().empty())
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} is of another realm than {}", where, certificate.subject(), authority.subject()));
  return {};
}

Result<void> check_authority(const Certificate& certificate, AuthorityKind kind, WallTime now, std::string_view where) {
  const auto* what = kind == AuthorityKind::kIdentities ? "identities" : "permissions";
  if (auto dated = check_dates(certificate, now, where); !dated) return dated;
  if (!is_authority_of(kind, certificate))
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} is not an authority for {}", where, certificate.subject(), what));
  const bool signed_by_itself = X509_self_signed(certificate.get(), 1) == 1;
  ERR_clear_error();
  if (!signed_by_itself || !is_p256(X509_get0_pubkey(certificate.get())))
    return fail(ErrorCode::kInvalid,
                fmt::format("{}: {} is not signed by its own key on the curve P-256", where, certificate.subject()));
  return {};
}

}  // namespace rubicon::trust
