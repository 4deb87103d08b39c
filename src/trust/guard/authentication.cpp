#include <dds/security/dds_security_api_authentication.h>

#include <algorithm>
#include <mutex>
#include <span>
#include <string_view>

#include "trust/guard/builtin.h"
#include "trust/guard/data_only.h"
#include "trust/guard/guard.h"
#include "trust/guard/peers.h"
#include "trust/guard/refusal.h"
#include "trust/guard/watcher.h"

namespace rubicon::trust::guard {

namespace {

using Instance = dds_security_authentication;
using Exception = DDS_Security_SecurityException;
using Result = DDS_Security_ValidationResult_t;
using Message = DDS_Security_HandshakeMessageToken;

dds_security_authentication original;  ///< written once, before the first context is given away

bool is_done(Result result) {
  return result == DDS_SECURITY_VALIDATION_OK || result == DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE;
}

/// Of a handshake message; it comes from anybody.
std::string_view binary_property(const Message* message, std::string_view name) {
  if (message == nullptr) return {};
  for (std::uint32_t i = 0; i < message->binary_properties._length; ++i) {
    const auto& property = message->binary_properties._buffer[i];
    if (property.name != nullptr && property.name == name && property.value._buffer != nullptr)
      return {reinterpret_cast<const char*>(property.value._buffer), property.value._length};
  }
  return {};
}

Result refuse(const Refused& peer, const std::string& reason, Exception* exception) {
  explain(exception, peer.name, reason);
  report(peer, reason);
  return DDS_SECURITY_VALIDATION_FAILED;
}

/// Notes whether the handshake failed: its peer has to wait before the next one. Then the answer is PENDING_RETRY:
/// Cyclone asks again after a second, with the same message or the one that came meanwhile.
Result failed(Handle identity, Result result, std::string_view foreign = {}) {
  if (result == DDS_SECURITY_VALIDATION_FAILED) peers().failed(identity, Clock::now(), foreign);
  return result;
}

/// Whether the built-in plug-in refused the certificate itself (auth_utils.c, verify_certificate), and not what else is
/// in a message that anyone can send.
bool is_foreign(const Exception* exception) {
  return reason_of(exception).find("Certificate not valid") != std::string::npos;
}

/// The certificate that the built-in plug-in has verified in this handshake.
Reading verified_certificate(Instance* instance, DDS_Security_HandshakeHandle handshake) {
  DDS_Security_AuthenticatedPeerCredentialToken token{};
  Exception exception{};
  if (original.get_authenticated_peer_credential_token(instance, &token, handshake, &exception) == 0) {
    clear(exception);
    return {{}, "its certificate is not there"};
  }
  Reading read{{}, "its certificate is not there"};
  for (std::uint32_t i = 0; i < token.properties._length; ++i) {
    const auto& property = token.properties._buffer[i];
    if (property.name == nullptr || property.value == nullptr || std::string_view(property.name) != "c.id") continue;
    read = read_certificate(property.value);
    break;
  }
  original.return_authenticated_peer_credential_token(instance, &token, &exception);
  return read;
}

/// What the guard makes of what the built-in plug-in thinks of a handshake.
Result judge(Instance* instance, DDS_Security_HandshakeHandle handshake, const Message* message, Result result,
             Exception* exception) {
  const auto peer = peers().of_handshake(handshake);
  if (result == DDS_SECURITY_VALIDATION_FAILED && peer) {
    report({peer->prefix, claimed_name(binary_property(message, "c.id"))}, reason_of(exception));
  }
  if (!is_done(result)) return result;
  if (!peer) return refuse({}, "its handshake is not known, too many others are under way", exception);
  const auto read = verified_certificate(instance, handshake);
  if (!read.certificate) return refuse({peer->prefix}, read.reason, exception);
  const auto& certificate = *read.certificate;
  const Refused member{peer->prefix, certificate.name, true};
  if (!std::ranges::equal(certificate.prefix, std::span(peer->prefix).first<std::tuple_size_v<Prefix>>()))
    return refuse(member, "its GUID belongs to the certificate of another", exception);
  if (peers().is_revoked(certificate.serial)) return refuse(member, "its certificate is revoked", exception);
  peers().authenticated(peer->identity, certificate);
  return result;
}

Result validate_remote_identity(Instance* instance, DDS_Security_IdentityHandle* remote,
                                DDS_Security_AuthRequestMessageToken* request_out,
                                const DDS_Security_AuthRequestMessageToken* request_in,
                                const DDS_Security_IdentityHandle local, const DDS_Security_IdentityToken* token,
                                const DDS_Security_GUID_t* guid, Exception* exception) noexcept {
  const auto result =
      original.validate_remote_identity(instance, remote, request_out, request_in, local, token, guid, exception);
  if (guid == nullptr) return DDS_SECURITY_VALIDATION_FAILED;
  GuidPrefix prefix{};
  std::copy(std::begin(guid->prefix), std::end(guid->prefix), prefix.begin());
  if (result == DDS_SECURITY_VALIDATION_FAILED) {
    report({prefix}, reason_of(exception));
  } else if (remote != nullptr && *remote != 0 && !peers().met(*remote, prefix)) {
    return refuse({prefix}, "too many peers", exception);
  }
  return result;
}

Result begin_handshake_request(Instance* instance, DDS_Security_HandshakeHandle* handshake, Message* message_out,
                               const DDS_Security_IdentityHandle local, const DDS_Security_IdentityHandle remote,
                               const DDS_Security_OctetSeq* data, Exception* exception) noexcept {
  if (peers().must_wait(remote, Clock::now())) return DDS_SECURITY_VALIDATION_PENDING_RETRY;
  const auto result =
      original.begin_handshake_request(instance, handshake, message_out, local, remote, data, exception);
  if (result == DDS_SECURITY_VALIDATION_FAILED) {  // the handshake may be unset
    if (const auto prefix = peers().prefix_of(remote)) report({*prefix}, reason_of(exception));
    return failed(remote, result);
  }
  peers().shakes_hands(*handshake, remote);
  return failed(remote, judge(instance, *handshake, nullptr, result, exception));
}

Result begin_handshake_reply(Instance* instance, DDS_Security_HandshakeHandle* handshake, Message* message_out,
                             const Message* message_in, const DDS_Security_IdentityHandle remote,
                             const DDS_Security_IdentityHandle local, const DDS_Security_OctetSeq* data,
                             Exception* exception) noexcept {
  const auto certificate = binary_property(message_in, "c.id");
  if (peers().must_wait(remote, certificate, Clock::now())) return DDS_SECURITY_VALIDATION_PENDING_RETRY;
  const auto result =
      original.begin_handshake_reply(instance, handshake, message_out, message_in, remote, local, data, exception);
  if (result == DDS_SECURITY_VALIDATION_FAILED) {
    const bool foreign = is_foreign(exception);
    if (const auto prefix = peers().prefix_of(remote))
      report({*prefix, claimed_name(certificate)}, reason_of(exception));
    return failed(remote, result, foreign ? certificate : std::string_view());
  }
  peers().shakes_hands(*handshake, remote);
  return failed(remote, judge(instance, *handshake, message_in, result, exception));
}

Result process_handshake(Instance* instance, Message* message_out, const Message* message_in,
                         const DDS_Security_HandshakeHandle handshake, Exception* exception) noexcept {
  const auto peer = peers().of_handshake(handshake);
  const auto result =
      judge(instance, handshake, message_in,
            original.process_handshake(instance, message_out, message_in, handshake, exception), exception);
  return peer ? failed(peer->identity, result) : result;
}

DDS_Security_boolean return_handshake_handle(Instance* instance, const DDS_Security_HandshakeHandle handshake,
                                             Exception* exception) noexcept {
  peers().is_over(handshake);  // before it is freed, as below
  return original.return_handshake_handle(instance, handshake, exception);
}

DDS_Security_boolean return_identity_handle(Instance* instance, const DDS_Security_IdentityHandle identity,
                                            Exception* exception) noexcept {
  peers().gone(identity);  // before it is freed: afterwards another may have the same address
  return original.return_identity_handle(instance, identity, exception);
}

}  // namespace

}  // namespace rubicon::trust::guard

extern "C" int rubicon_guard_init_authentication(const char* argument, void** context, ddsi_domaingv* domain) noexcept {
  using namespace rubicon::trust;
  if (!guard::make_builtin("dds_security_auth", "init_authentication", argument, context, domain)) return -1;
  rubicon_guard_take_data_only(domain);
  auto& plugin = *static_cast<dds_security_authentication*>(*context);
  static std::once_flag once;
  std::call_once(once, [&] { guard::original = plugin; });
  plugin.validate_remote_identity = guard::validate_remote_identity;
  plugin.begin_handshake_request = guard::begin_handshake_request;
  plugin.begin_handshake_reply = guard::begin_handshake_reply;
  plugin.process_handshake = guard::process_handshake;
  plugin.return_handshake_handle = guard::return_handshake_handle;
  plugin.return_identity_handle = guard::return_identity_handle;
  return 0;
}

extern "C" int rubicon_guard_finalize_authentication(void* context) noexcept {
  return rubicon::trust::guard::end_builtin("dds_security_auth", "finalize_authentication", context);
}
