#pragma once

struct ddsi_domaingv;

namespace rubicon::trust::guard {

/// Opens one of Cyclone's own plug-ins ("dds_security_auth") and calls its `init` function, which makes the context.
/// False: it cannot be opened or made; *context is then nullptr. The library stays open for good: contexts of other
/// domains, and the functions that the guard keeps of it, live there.
bool make_builtin(const char* library, const char* init, const char* argument, void** context, ddsi_domaingv* domain);
/// Calls its `finalize` function; 0 = done.
int end_builtin(const char* library, const char* finalize, void* context);

}  // namespace rubicon::trust::guard
