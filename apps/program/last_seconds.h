#pragma once

namespace rubicon::program {

/// From now on the process ends within two seconds with this code, whatever its destructors do: Cyclone DDS waits for
/// good for a thread that nothing wakes once the address of its interface is gone (dds_delete, 0.10.2). May be called
/// by a signal handler. The last call counts.
void end_within_seconds(int code);
/// It may take longer again.
void end_whenever_done();

}  // namespace rubicon::program
