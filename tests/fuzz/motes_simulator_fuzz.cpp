#include <cstdlib>

#include "apps/simulators/motes/world.h"
#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "motes/framing.h"

namespace rubicon::fuzz::motes_simulator_fuzz {

namespace {

/// The output of a sink is valid whatever its serial line receives.
void check_sink(ByteView bytes) {
  VirtualScheduler time;
  motes_simulator::WorldOptions options;
  motes_simulator::MoteOptions mote;
  mote.obey = mote.updates = true;
  options.add_motes(1, 2, 2, mote);
  options.sink.readings = true;
  motes_simulator::World world(options, time);
  motes::HdlcReader reader;
  world.sink(1).connect([&reader](ByteView out) {
    if (!reader.next(out) || !out.empty()) std::abort();
  });
  time.run_for(std::chrono::seconds(1));
  world.sink(1).received(bytes);
  time.run_for(std::chrono::seconds(3));
  if (reader.faults() != motes::HdlcFaults{}) std::abort();
}

}  // namespace

/// Input: a byte that selects the kind, then a script, or what a computer sends to a sink.
FUZZ_TARGET(motes_simulator) {
  if (size == 0) return 0;
  const ByteView rest{data + 1, size - 1};
  if (data[0] != 's') {
    check_sink(rest);
    return 0;
  }
  const auto steps = motes_simulator::parse_script(base::as_text(rest));
  if (!steps && steps.error().text.empty()) std::abort();
  return 0;
}

}  // namespace rubicon::fuzz::motes_simulator_fuzz
