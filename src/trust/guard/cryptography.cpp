#include <dds/security/dds_security_api_cryptography.h>

#include <mutex>

#include "trust/guard/builtin.h"
#include "trust/guard/guard.h"
#include "trust/guard/matches.h"
#include "trust/guard/refusal.h"
#include "trust/guard/watcher.h"

namespace rubicon::trust::guard {

namespace {

using Factory = dds_security_crypto_key_factory;
using Exception = DDS_Security_SecurityException;
using Crypto = DDS_Security_CryptoHandle;
using Attributes = DDS_Security_EndpointSecurityAttributes;

dds_security_crypto_key_factory original;  ///< written once, before the first context is given away

/// The property `builtin_endpoint_name` is not there for all of Cyclone's own endpoints.
bool is_builtin(const Attributes& attributes) {
  return attributes.is_read_protected == 0 && attributes.is_write_protected == 0;
}

Masks masks_of(const Attributes& attributes) {
  std::uint32_t mask = DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_VALID;
  const auto add = [&](DDS_Security_boolean is, std::uint32_t flag) { mask |= is != 0 ? flag : 0; };
  add(attributes.is_read_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_READ_PROTECTED);
  add(attributes.is_write_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_WRITE_PROTECTED);
  add(attributes.is_discovery_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_DISCOVERY_PROTECTED);
  add(attributes.is_submessage_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_SUBMESSAGE_PROTECTED);
  add(attributes.is_payload_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_PAYLOAD_PROTECTED);
  add(attributes.is_key_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_KEY_PROTECTED);
  add(attributes.is_liveliness_protected, DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_LIVELINESS_PROTECTED);
  return {mask, attributes.plugin_endpoint_attributes};
}

/// True: they may exchange keys. Else the exception says why not, and the watcher knows.
bool admit(Kind kind, Crypto local, Crypto remote, Exception* exception) {
  auto reason = matches().refusal(kind, local, remote);
  const auto identity = matches().identity_of(remote);
  const auto peer = peers().who(identity);
  if (!reason && peer && peers().is_revoked(peer->serial)) reason = "its certificate is revoked";
  if (!reason && !peer) reason = "it has not authenticated itself";
  if (!reason) return true;
  const auto name = peer ? peer->name : std::string();
  explain(exception, name, *reason);
  report({peers().prefix_of(identity).value_or(GuidPrefix{}), name, peer.has_value()}, *reason);
  return false;
}

Crypto register_matched_remote_participant(Factory* factory, const Crypto local,
                                           const DDS_Security_IdentityHandle identity,
                                           const DDS_Security_PermissionsHandle permissions,
                                           const DDS_Security_SharedSecretHandle secret,
                                           Exception* exception) noexcept {
  const auto remote =
      original.register_matched_remote_participant(factory, local, identity, permissions, secret, exception);
  if (remote != 0) matches().participant(permissions, remote, identity);
  return remote;
}

Crypto register_local_datawriter(Factory* factory, const Crypto participant, const DDS_Security_PropertySeq* properties,
                                 const Attributes* attributes, Exception* exception) noexcept {
  const auto local = original.register_local_datawriter(factory, participant, properties, attributes, exception);
  if (local != 0) matches().local_endpoint(local, is_builtin(*attributes), masks_of(*attributes));
  return local;
}

Crypto register_local_datareader(Factory* factory, const Crypto participant, const DDS_Security_PropertySeq* properties,
                                 const Attributes* attributes, Exception* exception) noexcept {
  const auto local = original.register_local_datareader(factory, participant, properties, attributes, exception);
  if (local != 0) matches().local_endpoint(local, is_builtin(*attributes), masks_of(*attributes));
  return local;
}

Crypto register_matched_remote_datareader(Factory* factory, const Crypto writer, const Crypto remote,
                                          const DDS_Security_SharedSecretHandle secret,
                                          const DDS_Security_boolean relay_only, Exception* exception) noexcept {
  if (!admit(Kind::Reader, writer, remote, exception)) return 0;
  const auto match =
      original.register_matched_remote_datareader(factory, writer, remote, secret, relay_only, exception);
  if (match != 0) matches().matched(match, writer);
  return match;
}

Crypto register_matched_remote_datawriter(Factory* factory, const Crypto reader, const Crypto remote,
                                          const DDS_Security_SharedSecretHandle secret, Exception* exception) noexcept {
  if (!admit(Kind::Writer, reader, remote, exception)) return 0;
  const auto match = original.register_matched_remote_datawriter(factory, reader, remote, secret, exception);
  if (match != 0) matches().matched(match, reader);
  return match;
}

DDS_Security_boolean unregister_participant(Factory* factory, const Crypto participant, Exception* exception) noexcept {
  matches().participant_gone(participant);
  return original.unregister_participant(factory, participant, exception);
}

DDS_Security_boolean unregister_datawriter(Factory* factory, const Crypto endpoint, Exception* exception) noexcept {
  matches().endpoint_gone(endpoint);
  return original.unregister_datawriter(factory, endpoint, exception);
}

DDS_Security_boolean unregister_datareader(Factory* factory, const Crypto endpoint, Exception* exception) noexcept {
  matches().endpoint_gone(endpoint);
  return original.unregister_datareader(factory, endpoint, exception);
}

}  // namespace

}  // namespace rubicon::trust::guard

extern "C" int rubicon_guard_init_crypto(const char* argument, void** context, ddsi_domaingv* domain) noexcept {
  using namespace rubicon::trust;
  if (!guard::make_builtin("dds_security_crypto", "init_crypto", argument, context, domain)) return -1;
  auto& factory = *static_cast<dds_security_cryptography*>(*context)->crypto_key_factory;
  static std::once_flag once;
  std::call_once(once, [&] { guard::original = factory; });
  factory.register_matched_remote_participant = guard::register_matched_remote_participant;
  factory.register_local_datawriter = guard::register_local_datawriter;
  factory.register_local_datareader = guard::register_local_datareader;
  factory.register_matched_remote_datareader = guard::register_matched_remote_datareader;
  factory.register_matched_remote_datawriter = guard::register_matched_remote_datawriter;
  factory.unregister_participant = guard::unregister_participant;
  factory.unregister_datawriter = guard::unregister_datawriter;
  factory.unregister_datareader = guard::unregister_datareader;
  return 0;
}

extern "C" int rubicon_guard_finalize_crypto(void* context) noexcept {
  return rubicon::trust::guard::end_builtin("dds_security_crypto", "finalize_crypto", context);
}
