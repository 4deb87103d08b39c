#include "tuples/dds/secure_participant.h"

#include <algorithm>

namespace rubicon::tuples::dds {

/// Names: DDS Security 1.1, tables 34, 47 and Cyclone's `dds.sec.*.library.*`; functions: trust/guard/guard.h.
Qos make_secure_qos(const DdsTrust::Documents& documents, const std::string& guard_library) {
  auto qos = make_qos();
  const auto set = [&qos](const std::string& name, const std::string& value) {
    dds_qset_prop(qos.get(), ("dds.sec." + name).c_str(), value.c_str());
  };
  const auto plug_in = [&](const std::string& kind, const std::string& function) {
    set(kind + ".library.path", guard_library);
    set(kind + ".library.init", "rubicon_guard_init_" + function);
    set(kind + ".library.finalize", "rubicon_guard_finalize_" + function);
  };
  plug_in("auth", "authentication");
  plug_in("access", "access_control");
  plug_in("crypto", "crypto");
  set("auth.identity_ca", documents.identity_ca);
  set("auth.identity_certificate", documents.certificate);
  set("auth.private_key", documents.private_key);
  set("access.permissions_ca", documents.permissions_ca);
  set("access.governance", documents.governance);
  set("access.permissions", documents.permissions);
  return qos;
}

GuidPrefix prefix_of_own(dds_entity_t participant) {
  dds_guid_t guid{};
  GuidPrefix prefix{};
  if (dds_get_guid(participant, &guid) == DDS_RETCODE_OK)
    std::copy_n(std::begin(guid.v), prefix.size(), prefix.begin());
  return prefix;
}

}  // namespace rubicon::tuples::dds
