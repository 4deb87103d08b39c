#pragma once

#include <sys/types.h>

namespace rubicon::bench {

/// Processor time of the calling thread so far.
double thread_seconds();
/// Processor time of a process so far, of the threads that it has now.
double processor_seconds(pid_t pid);
/// Of this process, in MB (10^6 bytes).
double resident_mb();
/// The part of it that this process wrote: without pages of programs and libraries, which all processes share.
double private_mb();
/// Highest resident_mb() since forget_peak().
double peak_mb();
void forget_peak();

}  // namespace rubicon::bench
