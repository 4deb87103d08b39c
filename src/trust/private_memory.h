#pragma once

namespace rubicon::trust {

/// For a program that reads a key, before it does: from then on this process writes no core file, which would have the
/// key, and no other process of its user looks into its memory. A library does not decide that for its program.
void keep_memory_private();

}  // namespace rubicon::trust
