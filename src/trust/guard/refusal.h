#pragma once

#include <dds/security/dds_security_api_types.h>

#include <string>

namespace rubicon::trust::guard {

/// Makes the exception of a plug-in say why a peer is refused; Cyclone logs it and frees it. nullptr is ignored.
void explain(DDS_Security_SecurityException* exception, const std::string& name, const std::string& reason);

/// What a plug-in put there, printable, at most 256 characters.
std::string reason_of(const DDS_Security_SecurityException* exception);

/// Frees what a plug-in put there.
void clear(DDS_Security_SecurityException& exception);

}  // namespace rubicon::trust::guard
