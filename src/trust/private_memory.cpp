#include "trust/private_memory.h"

#include <sys/prctl.h>
#include <sys/resource.h>

namespace rubicon::trust {

void keep_memory_private() {
  constexpr rlimit kNone{0, 0};
  ::setrlimit(RLIMIT_CORE, &kNone);
  ::prctl(PR_SET_DUMPABLE, 0);
}

}  // namespace rubicon::trust
