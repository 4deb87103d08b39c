// A member with a modified stack: linked before libddsc and named as the three security plug-ins, it lies as the
// environment's LIAR says. Words:
//   any-partition   its own access control allows all of its endpoints
//   no-bits         announces its endpoints without security attributes: DDS Security 1.1, 7.4.1.5
//   other-bits:PARTITION  announces the endpoints in it with attributes that differ from those of the topic
//   prefix:HEX      the first 6 bytes of its GUID are these; the handshake shows those of its certificate
//   permissions:FILE  sends this signed document in the handshake instead of its own
#include <dds/ddsi/ddsi_plist.h>
#include <dds/ddsrt/dynlib.h>
#include <dds/security/dds_security_api_access_control.h>
#include <dds/security/dds_security_api_authentication.h>
#include <dds/security/dds_security_api_cryptography.h>
#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace {

using Prefix = std::array<unsigned char, 12>;

bool lies(const std::string& word) {
  const char* all = std::getenv("LIAR");
  return all != nullptr && std::string(all).find(word) != std::string::npos;
}

/// What follows a word that ends with a colon.
std::string argument_of(const std::string& word) {
  const std::string words = std::getenv("LIAR");
  const auto begin = words.find(word) + word.size();
  return words.substr(begin, words.find(' ', begin) - begin);
}

dds_security_authentication auth;
Prefix true_prefix, false_prefix;

DDS_Security_ValidationResult_t validate_local_identity(dds_security_authentication* instance,
                                                        DDS_Security_IdentityHandle* handle, DDS_Security_GUID_t* guid,
                                                        const DDS_Security_DomainId domain, const DDS_Security_Qos* qos,
                                                        const DDS_Security_GUID_t* candidate,
                                                        DDS_Security_SecurityException* exception) {
  const auto result = auth.validate_local_identity(instance, handle, guid, domain, qos, candidate, exception);
  std::copy_n(guid->prefix, true_prefix.size(), true_prefix.begin());
  const auto digits = argument_of("prefix:");
  for (std::size_t i = 0; i < 6; ++i)
    guid->prefix[i] = static_cast<unsigned char>(std::stoi(digits.substr(2 * i, 2), nullptr, 16));
  std::copy_n(guid->prefix, false_prefix.size(), false_prefix.begin());
  return result;
}

/// The same with the GUID that fits the certificate.
std::string patched(const DDS_Security_OctetSeq* data) {
  std::string bytes(reinterpret_cast<const char*>(data->_buffer), data->_length);
  const auto at = std::search(bytes.begin(), bytes.end(), false_prefix.begin(), false_prefix.end(),
                              [](char a, unsigned char b) { return static_cast<unsigned char>(a) == b; });
  if (at != bytes.end()) std::copy(true_prefix.begin(), true_prefix.end(), at);
  return bytes;
}

DDS_Security_OctetSeq sequence_of(std::string& bytes) {
  const auto size = static_cast<std::uint32_t>(bytes.size());
  return {size, size, reinterpret_cast<unsigned char*>(bytes.data())};
}

DDS_Security_ValidationResult_t begin_handshake_request(dds_security_authentication* instance,
                                                        DDS_Security_HandshakeHandle* handshake,
                                                        DDS_Security_HandshakeMessageToken* out,
                                                        const DDS_Security_IdentityHandle local,
                                                        const DDS_Security_IdentityHandle remote,
                                                        const DDS_Security_OctetSeq* data,
                                                        DDS_Security_SecurityException* exception) {
  auto bytes = patched(data);
  const auto sequence = sequence_of(bytes);
  return auth.begin_handshake_request(instance, handshake, out, local, remote, &sequence, exception);
}

DDS_Security_ValidationResult_t begin_handshake_reply(
    dds_security_authentication* instance, DDS_Security_HandshakeHandle* handshake,
    DDS_Security_HandshakeMessageToken* out, const DDS_Security_HandshakeMessageToken* in,
    const DDS_Security_IdentityHandle remote, const DDS_Security_IdentityHandle local,
    const DDS_Security_OctetSeq* data, DDS_Security_SecurityException* exception) {
  auto bytes = patched(data);
  const auto sequence = sequence_of(bytes);
  return auth.begin_handshake_reply(instance, handshake, out, in, remote, local, &sequence, exception);
}

DDS_Security_boolean set_permissions(dds_security_authentication* instance, const DDS_Security_IdentityHandle identity,
                                     const DDS_Security_PermissionsCredentialToken* own,
                                     const DDS_Security_PermissionsToken* token,
                                     DDS_Security_SecurityException* exception) {
  std::ifstream file(argument_of("permissions:"), std::ios::binary);
  std::string document(std::istreambuf_iterator<char>(file), {});
  auto property = own->properties._buffer[0];
  property.value = document.data();
  auto foreign = *own;
  foreign.properties = {1, 1, &property};
  return auth.set_permissions_credential_and_token(instance, identity, &foreign, token, exception);
}

DDS_Security_boolean allow_endpoint(dds_security_access_control*, const DDS_Security_PermissionsHandle,
                                    const DDS_Security_DomainId, const DDS_Security_char*, const DDS_Security_Qos*,
                                    const DDS_Security_PartitionQosPolicy*, const DDS_Security_DataTags*,
                                    DDS_Security_SecurityException*) {
  return 1;
}

int make(const char* library, const char* function, const char* argument, void** context, ddsi_domaingv* domain) {
  ddsrt_dynlib_t handle = nullptr;
  void* init = nullptr;
  if (ddsrt_dlopen(library, true, &handle) != DDS_RETCODE_OK) return -1;
  if (ddsrt_dlsym(handle, function, &init) != DDS_RETCODE_OK) return -1;
  return reinterpret_cast<int (*)(const char*, void**, ddsi_domaingv*)>(init)(argument, context, domain);
}

}  // namespace

extern "C" {

int liar_init_authentication(const char* argument, void** context, ddsi_domaingv* domain) {
  const int result = make("dds_security_auth", "init_authentication", argument, context, domain);
  auto& plugin = *static_cast<dds_security_authentication*>(*context);
  auth = plugin;
  if (lies("permissions:")) plugin.set_permissions_credential_and_token = set_permissions;
  if (!lies("prefix:")) return result;
  plugin.validate_local_identity = validate_local_identity;
  plugin.begin_handshake_request = begin_handshake_request;
  plugin.begin_handshake_reply = begin_handshake_reply;
  return result;
}

int liar_init_access_control(const char* argument, void** context, ddsi_domaingv* domain) {
  const int result = make("dds_security_ac", "init_access_control", argument, context, domain);
  auto& plugin = *static_cast<dds_security_access_control*>(*context);
  if (!lies("any-partition")) return result;
  plugin.check_create_datawriter = allow_endpoint;
  plugin.check_create_datareader = allow_endpoint;
  return result;
}

int liar_init_crypto(const char* argument, void** context, ddsi_domaingv* domain) {
  return make("dds_security_crypto", "init_crypto", argument, context, domain);
}

// The process ends with them.
int liar_finalize_authentication(void*) {
  return 0;
}
int liar_finalize_access_control(void*) {
  return 0;
}
int liar_finalize_crypto(void*) {
  return 0;
}

/// In place of that of libddsc: what endpoints are announced with.
void ddsi_plist_addtomsg(nn_xmsg* message, const ddsi_plist_t* list, uint64_t wanted, uint64_t wanted_qos) {
  static const auto real = reinterpret_cast<decltype(&ddsi_plist_addtomsg)>(::dlsym(RTLD_NEXT, "ddsi_plist_addtomsg"));
  const bool is_endpoint = (list->present & PP_ENDPOINT_SECURITY_INFO) != 0;
  const auto& partition = list->qos.partition;
  auto changed = *list;
  if (is_endpoint && partition.n > 0 && lies("other-bits:" + std::string(partition.strs[0]))) {
    changed.endpoint_security_info.security_attributes ^= DDS_SECURITY_ENDPOINT_ATTRIBUTES_FLAG_IS_KEY_PROTECTED;
  } else if (is_endpoint && lies("no-bits")) {
    changed.endpoint_security_info = {};
  }
  real(message, &changed, wanted, wanted_qos);
}
}
