#pragma once

namespace rubicon::knx_simulator {

/// The program knx-simulator: reads its command line and runs until a signal ends it. Returns its exit code.
int run_program(int argc, char** argv);

}  // namespace rubicon::knx_simulator
