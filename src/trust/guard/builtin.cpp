#include "trust/guard/builtin.h"

#include <dds/ddsrt/dynlib.h>

namespace rubicon::trust::guard {

namespace {

/// As dds_security_api.h has them.
using Init = int (*)(const char* argument, void** context, ddsi_domaingv* domain);
using Finalize = int (*)(void* context);

void* symbol_of(const char* library, const char* name) {
  ddsrt_dynlib_t handle = nullptr;
  void* symbol = nullptr;
  if (ddsrt_dlopen(library, true, &handle) != DDS_RETCODE_OK) return nullptr;
  if (ddsrt_dlsym(handle, name, &symbol) != DDS_RETCODE_OK) return nullptr;
  return symbol;
}

}  // namespace

bool make_builtin(const char* library, const char* init, const char* argument, void** context, ddsi_domaingv* domain) {
  *context = nullptr;
  const auto call = reinterpret_cast<Init>(symbol_of(library, init));
  return call != nullptr && call(argument, context, domain) == 0 && *context != nullptr;
}

int end_builtin(const char* library, const char* finalize, void* context) {
  const auto call = reinterpret_cast<Finalize>(symbol_of(library, finalize));
  return call == nullptr ? -1 : call(context);
}

}  // namespace rubicon::trust::guard
