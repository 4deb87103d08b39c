#include <dds/security/dds_security_api_access_control.h>

#include <mutex>

#include "trust/guard/builtin.h"
#include "trust/guard/guard.h"
#include "trust/guard/matches.h"
#include "trust/guard/refusal.h"
#include "trust/guard/watcher.h"

namespace rubicon::trust::guard {

namespace {

using Instance = dds_security_access_control;
using Exception = DDS_Security_SecurityException;
using Permissions = DDS_Security_PermissionsHandle;

dds_security_access_control original;  ///< written once, before the first context is given away

std::string text(const char* it) {
  return it == nullptr ? "" : it;
}

std::vector<std::string> names_of(const DDS_Security_PartitionQosPolicy* partition) {
  std::vector<std::string> names;
  if (partition == nullptr) return names;
  for (std::uint32_t i = 0; i < partition->name._length; ++i) names.push_back(text(partition->name._buffer[i]));
  return names;
}

template <class Announced>
void approve(Kind kind, Permissions permissions, const Announced& endpoint) {
  Matches::approve(
      {kind,
       permissions,
       endpoint.topic_name,
       {endpoint.security_info.endpoint_security_mask, endpoint.security_info.plugin_endpoint_security_mask},
       text(endpoint.topic_name),
       names_of(&endpoint.partition)});
}

/// Of the remote participant that this thread asks about: Cyclone validates its permissions, then checks them.
thread_local DDS_Security_IdentityHandle asked_about = 0;

void report_refusal(const Exception* exception) {
  const auto peer = peers().who(asked_about);
  report({peers().prefix_of(asked_about).value_or(GuidPrefix{}), peer ? peer->name : "", peer.has_value()},
         reason_of(exception));
}

Permissions validate_remote_permissions(Instance* instance, const dds_security_authentication* authentication,
                                        const DDS_Security_IdentityHandle local,
                                        const DDS_Security_IdentityHandle remote,
                                        const DDS_Security_PermissionsToken* token,
                                        const DDS_Security_AuthenticatedPeerCredentialToken* credential,
                                        Exception* exception) noexcept {
  asked_about = remote;
  const auto permissions =
      original.validate_remote_permissions(instance, authentication, local, remote, token, credential, exception);
  if (permissions == 0) report_refusal(exception);
  return permissions;
}

DDS_Security_boolean check_remote_participant(Instance* instance, const Permissions permissions,
                                              const DDS_Security_DomainId domain,
                                              const DDS_Security_ParticipantBuiltinTopicDataSecure* participant,
                                              Exception* exception) noexcept {
  const auto answer = original.check_remote_participant(instance, permissions, domain, participant, exception);
  if (answer == 0) report_refusal(exception);
  return answer;
}

/// `check` is the function of the built-in plug-in for writers, or for readers, which has one argument more.
template <Kind kind, auto check, class Endpoint, class... More>
DDS_Security_boolean check_endpoint(Instance* instance, const Permissions permissions,
                                    const DDS_Security_DomainId domain, const Endpoint* endpoint,
                                    More... more) noexcept {
  Matches::ask();
  const auto answer = (original.*check)(instance, permissions, domain, endpoint, more...);
  if (answer != 0) approve(kind, permissions, *endpoint);
  return answer;
}

/// Asked after the endpoint of that topic.
DDS_Security_boolean check_remote_topic(Instance* instance, const Permissions permissions,
                                        const DDS_Security_DomainId domain,
                                        const DDS_Security_TopicBuiltinTopicData* topic,
                                        Exception* exception) noexcept {
  const auto answer = original.check_remote_topic(instance, permissions, domain, topic, exception);
  if (answer == 0) Matches::ask();
  return answer;
}

/// `get` is the function of the built-in plug-in for writers or for readers.
template <auto get>
DDS_Security_boolean get_endpoint_attributes(Instance* instance, const Permissions permissions,
                                             const DDS_Security_char* topic,
                                             const DDS_Security_PartitionQosPolicy* partition,
                                             const DDS_Security_DataTagQosPolicy* tag,
                                             DDS_Security_EndpointSecurityAttributes* attributes,
                                             Exception* exception) noexcept {
  matches().prepare(text(topic), names_of(partition));
  return (original.*get)(instance, permissions, topic, partition, tag, attributes, exception);
}

DDS_Security_boolean return_permissions_handle(Instance* instance, Permissions permissions,
                                               Exception* exception) noexcept {
  matches().permissions_gone(permissions);
  return original.return_permissions_handle(instance, permissions, exception);
}

}  // namespace

}  // namespace rubicon::trust::guard

extern "C" int rubicon_guard_init_access_control(const char* argument, void** context, ddsi_domaingv* domain) noexcept {
  using namespace rubicon::trust;
  if (!guard::make_builtin("dds_security_ac", "init_access_control", argument, context, domain)) return -1;
  auto& plugin = *static_cast<dds_security_access_control*>(*context);
  static std::once_flag once;
  std::call_once(once, [&] { guard::original = plugin; });
  plugin.validate_remote_permissions = guard::validate_remote_permissions;
  plugin.check_remote_participant = guard::check_remote_participant;
  using Plugin = dds_security_access_control;
  plugin.check_remote_datawriter = guard::check_endpoint<guard::Kind::Writer, &Plugin::check_remote_datawriter>;
  plugin.check_remote_datareader = guard::check_endpoint<guard::Kind::Reader, &Plugin::check_remote_datareader>;
  plugin.check_remote_topic = guard::check_remote_topic;
  plugin.get_datawriter_sec_attributes = guard::get_endpoint_attributes<&Plugin::get_datawriter_sec_attributes>;
  plugin.get_datareader_sec_attributes = guard::get_endpoint_attributes<&Plugin::get_datareader_sec_attributes>;
  plugin.return_permissions_handle = guard::return_permissions_handle;
  return 0;
}

extern "C" int rubicon_guard_finalize_access_control(void* context) noexcept {
  return rubicon::trust::guard::end_builtin("dds_security_ac", "finalize_access_control", context);
}
